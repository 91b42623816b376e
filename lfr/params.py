"""Parameters: a section of params.yaml read into a frozen dataclass that rejects what it lacks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lfr.errors import ParameterError
from lfr.records import from_mapping, join

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
        node, where = node[name], join(where, name)
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
