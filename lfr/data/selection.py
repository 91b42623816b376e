"""A mapping of columns held against a dataset: which numbers of which column are meant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from lfr.columns import ActionPart, ActionSpace, Columns, Part
from lfr.data.episode import ACTION, ENVIRONMENT_STATE, STATE
from lfr.data.features import dimension_names
from lfr.data.tables import DatasetFiles
from lfr.errors import DataError, UnknownNameError
from lfr.spaces import quantity, quantity_name

RECORDED = Columns((Part(STATE), Part(ENVIRONMENT_STATE)), ActionPart(ACTION))
"""Of this project's own datasets."""


@dataclass(frozen=True)
class Chosen:
    """The dimensions of one column, by number, and what they are called here."""

    column: str
    places: tuple[int, ...]
    names: tuple[str, ...]
    unit: float = 1.0


@dataclass(frozen=True)
class Selection:
    """`Columns` with every dimension found in one dataset."""

    observation: tuple[Chosen, ...]
    action: Chosen
    space: ActionSpace

    @property
    def observation_names(self) -> tuple[str, ...]:
        return tuple(name for part in self.observation for name in part.names)


def select(files: DatasetFiles, columns: Columns) -> Selection:
    """Find every column and dimension in a dataset.

    Raises:
        DataError: a column or dimension is missing or is no vector of numbers, a name stands for
            two, or bounds do not fit the action. It names column, found and expected.
    """
    observation = tuple(_choose(files, part, part.unit) for part in columns.observation)
    names = [name for part in observation for name in part.names]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise DataError(
            "two dimensions of the observation have one name; give them others under 'names'",
            file=_info(files), found=twice,
        )  # fmt: skip
    action = _choose(files, columns.action)
    return Selection(observation, action, _space(files, columns.action, action))


def unreadable(names: Sequence[str]) -> tuple[str, ...]:
    """Those of the names that do not say what they are, by `lfr.spaces`."""
    found: list[str] = []
    for group, members in groupby(names, key=quantity_name):
        dimensions = list(members)
        try:
            known = quantity(group)
        except UnknownNameError:
            found += dimensions
        else:  # a part of a rotation is none
            found += dimensions if known.moves == "rotation" and len(dimensions) != 6 else []
    return tuple(found)


def _info(files: DatasetFiles) -> str:
    return str(files.path / "meta" / "info.json")


def _choose(files: DatasetFiles, part: Part | ActionPart, unit: float = 1.0) -> Chosen:
    if part.column not in files.features:
        raise DataError(
            "a column is missing", file=_info(files), column=part.column,
            found=", ".join(files.features), expected=part.column,
        )  # fmt: skip
    feature = files.features[part.column]
    if feature["dtype"] not in ("float32", "float64") or len(feature["shape"]) != 1:
        raise DataError(
            "no vector of numbers", file=_info(files), column=part.column,
            found=f"{feature['dtype']} of shape {tuple(feature['shape'])}",
            expected="float32 or float64 of shape (D,)",
        )  # fmt: skip
    given = dimension_names(feature, part.column)
    places = tuple(_place(files, part.column, one, given) for one in part.dims or range(len(given)))
    names = part.names or tuple(given[place] for place in places)
    if len(names) != len(places):
        raise DataError(
            "another number of names than dimensions", file=_info(files), column=part.column,
            found=f"{len(names)} names", expected=f"{len(places)}: {', '.join(given)}",
        )  # fmt: skip
    return Chosen(part.column, places, names, unit)


def _place(files: DatasetFiles, column: str, one: str | int, given: Sequence[str]) -> int:
    if isinstance(one, int) and 0 <= one < len(given):
        return one
    if one in given:
        return list(given).index(str(one))
    raise DataError(
        "no such dimension", file=_info(files), column=column, found=", ".join(given),
        expected=one,
    )  # fmt: skip


def _space(files: DatasetFiles, part: ActionPart, action: Chosen) -> ActionSpace:
    size = len(action.names)
    bounds = []
    for what, value in (("low", part.low), ("high", part.high)):
        each = value if isinstance(value, tuple) else (float(value),) * size
        if len(each) != size:
            raise DataError(
                f"another number of values under {what!r} than the action has dimensions",
                file=_info(files), column=part.column, found=len(each), expected=size,
            )  # fmt: skip
        bounds.append(each)
    for name, low, high in zip(action.names, *bounds, strict=True):
        if not low < high:
            raise DataError(
                f"low is not below high for {name!r}", file=_info(files), column=part.column,
                found=f"{low} and {high}",
            )  # fmt: skip
    return ActionSpace(action.names, *bounds)
