"""The main job with plain demonstrations: what differs, and where its data and models lie.

docs/method.md lists what this project does beyond the paper. Section ``plain`` of paper/params.yaml
sets it back to the paper's reading, and two stages repeat the first half of the main job with it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from lfr.errors import ParameterError
from lfr.params import PARAMS as MAIN
from lfr.params import from_mapping, read_section, read_yaml
from pipeline.paper._stage import PARAMS

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

LOGS = Path("data/paper-plain/logs")
DATASETS = Path("data/paper-plain/lerobot")
MODELS = Path("models/paper-plain")
POLICIES = Path("models/paper-plain-policies")

SectionName = Literal["record", "skills", "mapping"]


@dataclass(frozen=True)
class PlainChanges:
    """Section ``plain``: of each of the main job's sections only what differs."""

    record: dict[str, Any] = field(default_factory=dict)
    skills: dict[str, Any] = field(default_factory=dict)
    mapping: dict[str, Any] = field(default_factory=dict)


def plain_section[Section: DataclassInstance](cls: type[Section], section: SectionName) -> Section:
    """A section of the main job's parameters with that of ``plain`` merged over it.

    Raises:
        ParameterError: either file lacks its section, or what comes of the two does not fit
            ``cls``.
    """
    main, changes = read_yaml(MAIN), read_section(PlainChanges, "plain", PARAMS)
    if section not in main:
        raise ParameterError(f"{MAIN}: no section {section!r}; found: {', '.join(sorted(main))}")
    whole = merged(main[section], getattr(changes, section))
    return from_mapping(cls, whole, f"{PARAMS}: plain.{section}")


def merged(main: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """``main`` with ``changes`` over it: mappings key by key, anything else as a whole.

    Neither is changed. A key that ``main`` lacks is added: whether there is such a parameter is for
    the dataclass to say.
    """
    both = dict(main)
    for key, new in changes.items():
        old = main.get(key)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            new = merged(old, new)
        both[key] = new
    return both
