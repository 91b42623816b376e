"""Parameters: a section of params.yaml read into a frozen dataclass that rejects what it lacks."""

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

PARAMS = Path("params.yaml")


def read_section[Section: DataclassInstance](
    cls: type[Section], section: str, path: Path = PARAMS
) -> Section:
    """A section of a YAML file as an instance of ``cls``.

    Args:
        cls: a dataclass, possibly nested.
        section: name of the section; a dotted name ("skills.vae") goes further down.
        path: the YAML file, read as DVC reads it (YAML 1.2: ``5e-4`` is a number).

    Raises:
        ParameterError: the file or the section is missing, or its content does not fit ``cls``.
    """
    node: Any = read_yaml(path)
    where = str(path)
    for name in section.split("."):
        valid = sorted(node) if isinstance(node, Mapping) else []
        if name not in valid:
            raise ParameterError(f"{where}: no section {name!r}; found: {', '.join(valid)}")
        node, where = node[name], _join(where, name)
    return from_mapping(cls, node, where)


def read_yaml(path: Path) -> dict[str, Any]:
    """A YAML file's mapping.

    Raises:
        ParameterError: the file is missing, is no YAML, or holds no mapping.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        content = YAML(typ="safe").load(path.read_text())
    except FileNotFoundError:
        raise ParameterError(f"{path} is missing; run in the project's folder") from None
    except YAMLError as error:
        raise ParameterError(f"{path} is no YAML: {' '.join(str(error).split())}") from None
    if not isinstance(content, dict):
        raise ParameterError(f"{path}: expected a mapping of sections")
    return content


def read_names(section: str, path: Path = PARAMS) -> list[str]:
    """The names that a section of a YAML file lists; none where there is no such section.

    Raises:
        ParameterError: the section is no list of names.
    """
    names = read_yaml(path).get(section, [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ParameterError(f"{path}: {section}: found {names!r}, expected a list of names")
    return names


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
        name: _checked(hints[name], value, _join(where, name)) for name, value in mapping.items()
    }
    try:
        return cls(**values)
    except (ValueError, ParameterError, UnknownNameError) as error:
        raise ParameterError(f"{where}: {error}") from None


_hints = cache(typing.get_type_hints)


def _join(where: str, name: str) -> str:
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
                arguments[1], item, _join(where, str(key))
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
