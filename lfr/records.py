"""Frozen dataclasses from mappings as YAML and JSON give them, every type checked."""

from __future__ import annotations

import contextlib
import dataclasses
import types
import typing
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Union

from lfr.errors import ParameterError, UnknownNameError

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


def from_mapping[Section: DataclassInstance](
    cls: type[Section], mapping: object, where: str
) -> Section:
    """An instance of the dataclass ``cls`` from a mapping, its types checked.

    Fields may be bool, int, float (an int will do), str, Path, None, Literal, unions of these,
    tuples (from lists), dict[str, ...], and dataclasses. What ``__post_init__`` refuses is a
    ParameterError that says where it stands.

    Args:
        where: the mapping's place, for messages, such as "params.yaml: skills".

    Raises:
        ParameterError: an unknown, missing or mistyped key; the message names the valid ones.
    """
    if not isinstance(mapping, Mapping):
        raise ParameterError(f"{where}: found {mapping!r}, expected a mapping")
    fields = {field.name: field for field in dataclasses.fields(cls) if field.init}
    for name in mapping:
        if name not in fields:
            raise ParameterError(f"{where}: unknown parameter {name!r}; valid: {', '.join(fields)}")
    for name, field in fields.items():
        defaults = (field.default, field.default_factory)
        if name not in mapping and all(value is dataclasses.MISSING for value in defaults):
            raise ParameterError(f"{where}: parameter {name!r} is missing")
    hints = _hints(cls)
    values = {
        name: _checked(hints[name], value, join(where, name)) for name, value in mapping.items()
    }
    try:
        return cls(**values)
    except (ValueError, ParameterError, UnknownNameError) as error:
        raise ParameterError(f"{where}: {error}") from None


_hints = cache(typing.get_type_hints)


def join(where: str, name: str) -> str:
    """The place of an entry, for messages: "params.yaml: skills.vae"."""
    return f"{where}.{name}" if ": " in where else f"{where}: {name}"


def _checked(kind: Any, value: Any, where: str) -> Any:
    """``value`` as the annotation ``kind`` wants it."""
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if kind is Any:
        return value
    if dataclasses.is_dataclass(kind):
        return from_mapping(typing.cast(type, kind), value, where)
    if origin in (Union, types.UnionType):
        return _checked_union(arguments, value, where)
    if origin is Literal:
        if any(value == valid and type(value) is type(valid) for valid in arguments):
            return value
        valid = ", ".join(str(name) for name in arguments)
        raise ParameterError(f"{where}: found {value!r}; valid: {valid}")
    if origin is tuple and isinstance(value, list | tuple):
        return _checked_tuple(arguments, value, where)
    if origin is dict and isinstance(value, Mapping):
        return {
            _checked(arguments[0], key, f"{where}: key"): _checked(
                arguments[1], item, join(where, str(key))
            )
            for key, item in value.items()
        }
    if kind is float and type(value) is int:  # bool is an int to Python, not to a reader
        return float(value)
    if kind is Path and isinstance(value, str):
        return Path(value)
    if kind in (bool, int, float, str) and type(value) is kind:
        return value
    expected = getattr(kind, "__name__", str(kind)) if origin is None else str(kind)
    if origin is tuple and arguments[-1] is Ellipsis:
        expected = "a list"
    raise ParameterError(f"{where}: found {value!r}, expected {expected}")


def _checked_union(kinds: tuple[Any, ...], value: Any, where: str) -> Any:
    wanted = [kind for kind in kinds if kind is not types.NoneType]
    if value is None and len(wanted) < len(kinds):
        return None
    if len(wanted) == 1:
        return _checked(wanted[0], value, where)
    for kind in wanted:
        with contextlib.suppress(ParameterError):
            return _checked(kind, value, where)
    if kind := _meant(wanted, value):
        return _checked(kind, value, where)  # raises, with what is wrong inside
    names = " or ".join(getattr(kind, "__name__", str(kind)) for kind in wanted)
    raise ParameterError(f"{where}: found {value!r}, expected {names}")


def _meant(kinds: list[Any], value: Any) -> Any:
    """Of the kinds in a union the one that a mapping or list is probably meant to be."""
    if isinstance(value, Mapping):
        known = {kind: len({field.name for field in dataclasses.fields(kind)} & set(value))
                 for kind in kinds if dataclasses.is_dataclass(kind)}  # fmt: skip
        return max(known, key=lambda kind: known[kind], default=None)
    lists = [kind for kind in kinds if typing.get_origin(kind) is tuple]
    return lists[0] if lists and isinstance(value, list | tuple) else None


def _checked_tuple(kinds: tuple[Any, ...], value: Any, where: str) -> tuple[Any, ...]:
    if len(kinds) == 2 and kinds[1] is Ellipsis:
        kinds = (kinds[0],) * len(value)
    elif len(kinds) != len(value):
        raise ParameterError(f"{where}: found {len(value)} values, expected {len(kinds)}")
    return tuple(
        _checked(kind, item, f"{where}[{index}]")
        for index, (kind, item) in enumerate(zip(kinds, value, strict=True))
    )
