"""What info.json says of one feature, in whichever of the usual forms, or wrong ones, it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def names_of(feature: Mapping[str, Any]) -> list[str]:
    """What a feature's dimensions are called; none where info.json does not say.

    Recorders write a list, a list in a list, `{"motors": [...]}`, or `{"delta_x": 0, ...}`.
    """
    return _flat(feature.get("names"))


def _flat(names: Any) -> list[str]:
    if isinstance(names, dict):
        named = list(names.values())
        names = named if any(isinstance(each, list | dict) for each in named) else list(names)
    if not isinstance(names, list):
        return []
    parts = (_flat(each) if isinstance(each, list | dict) else [str(each)] for each in names)
    return [name for part in parts for name in part]


def shape_of(feature: Mapping[str, Any]) -> list[Any]:
    """A feature's shape; empty where info.json has none."""
    shape = feature.get("shape")
    return shape if isinstance(shape, list) else []


def settings_of(feature: Mapping[str, Any]) -> dict[str, Any]:
    """What info.json keeps of a video's encoding."""
    info = feature.get("info")
    return info if isinstance(info, dict) else {}
