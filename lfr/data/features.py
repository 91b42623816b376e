"""What info.json says of one feature, in whichever of the usual forms, or wrong ones, it is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any


def names_of(feature: Mapping[str, Any]) -> list[str]:
    """What a feature's dimensions are called; none where info.json does not say.

    Recorders write a list, a list in a list, `{"motors": [...]}`, a list for each arm, whose name
    then stands in front, or `{"delta_x": 0, ...}`.
    """
    return _flat(feature.get("names"))


def _flat(names: Any) -> list[str]:
    if isinstance(names, Mapping):
        groups = {str(kind): _flat(part) for kind, part in names.items() if _holds(part)}
        if len(groups) > 1:
            return [f"{kind}.{name}" for kind, part in groups.items() for name in part]
        if groups:
            return next(iter(groups.values()))
        numbers = list(names.values())
        ordered = all(isinstance(n, int) for n in numbers) and len(set(numbers)) == len(numbers)
        return sorted(map(str, names), key=lambda n: names[n]) if ordered else list(map(str, names))
    if not isinstance(names, list):
        return []
    parts = (_flat(each) if _holds(each) else [str(each)] for each in names)
    return [name for part in parts for name in part]


def _holds(part: Any) -> bool:
    return isinstance(part, list | Mapping)


def dimension_names(feature: Mapping[str, Any], key: str) -> tuple[str, ...]:
    """What a feature's dimensions are called; `<key>.<number>` where info.json names other ones."""
    names, size = names_of(feature), math.prod(shape_of(feature))
    return tuple(names) if len(names) == size else tuple(f"{key}.{i}" for i in range(size))


def shape_of(feature: Mapping[str, Any]) -> list[Any]:
    """A feature's shape; empty where info.json has none."""
    shape = feature.get("shape")
    return shape if isinstance(shape, list) else []


def settings_of(feature: Mapping[str, Any]) -> dict[str, Any]:
    """What info.json keeps of a video's encoding."""
    info = feature.get("info")
    return info if isinstance(info, dict) else {}
