"""A mapping of columns held against a dataset: which numbers of which column are meant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from lfr.columns import ActionPart, ActionSpace, Columns, Part
from lfr.conversion import AS_IT_IS, Conversion
from lfr.data.episode import ACTION, ENVIRONMENT_STATE, STATE
from lfr.data.features import dimension_names
from lfr.data.tables import DatasetFiles
from lfr.errors import DataError, UnknownNameError
from lfr.spaces import quantity, quantity_name

RECORDED = Columns((Part(STATE), Part(ENVIRONMENT_STATE)), ActionPart(ACTION))
"""Of this project's own datasets."""


@dataclass(frozen=True)
class Chosen:
    """The dimensions of one column, by number, and what they become and are called here.

    Attributes:
        minus: column and places of what is taken off them.
    """

    column: str
    places: tuple[int, ...]
    names: tuple[str, ...]
    conversion: Conversion = AS_IT_IS
    minus: tuple[str, tuple[int, ...]] | None = None

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of all that it is made of."""
        return (self.column, *((self.minus[0],) if self.minus else ()))

    def values(self, column: Callable[[str], NDArray]) -> NDArray:
        """(..., D) as models know them.

        Args:
            column: the numbers (..., n) of a column by its name.

        Raises:
            ValueError: no unit quaternion.
        """
        found = _at(column(self.column), self.places)
        if self.minus is not None:
            found = found - _at(column(self.minus[0]), self.minus[1])
        return self.conversion(found, self.names)


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
    observation = tuple(_part(files, part) for part in columns.observation)
    names = [name for part in observation for name in part.names]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise DataError(
            "two dimensions of the observation have one name; give them others under 'names'",
            file=_info(files), found=twice,
        )  # fmt: skip
    for part in observation:
        _check_conversion(files, part)
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


def _at(values: NDArray, places: tuple[int, ...]) -> NDArray:
    return values if places == tuple(range(values.shape[-1])) else values[..., list(places)]


def _part(files: DatasetFiles, part: Part) -> Chosen:
    found = _choose(files, part, part.conversion)
    if part.minus is None:
        return found
    other = _choose(files, ActionPart(part.minus.column, part.minus.dims))
    if len(other.places) != len(found.places):
        raise DataError(
            "another number of dimensions under 'minus'", file=_info(files), column=part.column,
            found=len(other.places), expected=len(found.places),
        )  # fmt: skip
    return replace(found, minus=(other.column, other.places))


def _check_conversion(files: DatasetFiles, part: Chosen) -> None:
    """Names that cannot be read are told by others, in what reads the arms of params.yaml."""
    if unreadable(part.names):
        return
    try:
        part.conversion.check(part.names)
    except ValueError as error:
        raise DataError(str(error), file=_info(files), column=part.column) from None


def _choose(
    files: DatasetFiles, part: Part | ActionPart, conversion: Conversion = AS_IT_IS
) -> Chosen:
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
    if (len(places), len(names)) != (conversion.sizes or (len(places),) * 2):
        wanted = conversion.sizes or (len(places), len(places))
        raise DataError(
            "another number of names than dimensions", file=_info(files), column=part.column,
            found=f"{len(names)} names", expected=f"{wanted[1]}: {', '.join(given)}",
        )  # fmt: skip
    return Chosen(part.column, places, names, conversion)


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
        if low == high or not np.isfinite([low, high]).all():
            raise DataError(
                f"low and high bound nothing for {name!r}", file=_info(files), column=part.column,
                found=f"{low} and {high}",
            )  # fmt: skip
    return ActionSpace(action.names, *bounds)
