"""Which of a dataset's dimensions are observation and action, and what models know them by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lfr.conversion import UNITS, Conversion


def _check_names(
    column: str, dims: Sequence[str | int], names: Sequence[str],
    sizes: tuple[int, int] | None = None,
) -> None:  # fmt: skip
    if dims and names and (len(dims), len(names)) != (sizes or (len(dims),) * 2):
        expected = f"; {sizes[0]} become {sizes[1]}" if sizes else ""
        raise ValueError(f"{column}: found {len(names)} names for {len(dims)} dims{expected}")
    for what, given in (("dims", dims), ("names", names)):
        twice = [str(one) for one in dict.fromkeys(given) if list(given).count(one) > 1]
        if twice:
            raise ValueError(f"{column}: {', '.join(twice)} twice under {what}")


@dataclass(frozen=True)
class Subtracted:
    """Dimensions of one column, `column` and `dims` as of `Part`, that are taken off others."""

    column: str
    dims: tuple[str | int, ...] = ()


@dataclass(frozen=True)
class Part:
    """Dimensions of one column that go into the observation.

    Attributes:
        column: name of the column, e.g. "observation.state".
        dims: which of its dimensions and in which order, by the dataset's names or by number;
            () takes all.
        names: what models know them by, one for each; () keeps the dataset's names.
        minus: as many dimensions, of this or another column, in the same unit: what a ``<start>_to_
            <end>`` starts from. None takes off nothing.
        unit: of the column's numbers: its name, or the size of a metre or radian (or whatever 1
            stands for) in them. Below 0 it turns what is open and what is closed.
        zero, quaternion, frame: as of `Conversion`.
    """

    column: str
    dims: tuple[str | int, ...] = ()
    names: tuple[str, ...] = ()
    minus: Subtracted | None = None
    unit: float | Literal["m", "cm", "mm", "rad", "deg"] = 1.0
    zero: float | tuple[float, ...] = 0.0
    quaternion: Literal["", "xyzw", "wxyz"] = ""
    frame: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        try:
            sizes = self.conversion.sizes
        except ValueError as error:
            raise ValueError(f"{self.column}: {error}") from None
        _check_names(self.column, self.dims, self.names, sizes)

    @property
    def conversion(self) -> Conversion:
        """What is done to its numbers."""
        unit = UNITS[self.unit] if isinstance(self.unit, str) else self.unit
        return Conversion(self.zero, unit, self.quaternion, self.frame)


@dataclass(frozen=True)
class ActionPart:
    """Dimensions of one column that are the action.

    Attributes:
        column, dims, names: as of `Part`.
        low, high: what -1 and 1 stand for, of every dimension or of each; low above high turns it
            round.
        deltas: those of the names that are changes or speeds, which may be said only where control
            steps are resampled, and has to be there (`lfr.data.resample`).
    """

    column: str = "action"
    dims: tuple[str | int, ...] = ()
    names: tuple[str, ...] = ()
    low: float | tuple[float, ...] = -1.0
    high: float | tuple[float, ...] = 1.0
    deltas: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        _check_names(self.column, self.dims, self.names)


@dataclass(frozen=True)
class Columns:
    """How the rows of a dataset become observations and actions.

    Attributes:
        observation: its parts, one after the other.
        action: the action.
    """

    observation: tuple[Part, ...]
    action: ActionPart = ActionPart()

    def __post_init__(self) -> None:
        if not self.observation:
            raise ValueError("observation names no column")

    @property
    def needed(self) -> tuple[str, ...]:
        """The names of all columns."""
        taken_off = [part.minus.column for part in self.observation if part.minus]
        observed = [part.column for part in self.observation]
        return tuple(dict.fromkeys([*observed, *taken_off, self.action.column]))


@dataclass(frozen=True)
class ActionSpace:
    """What a model's actions in [-1, 1] stand for.

    Attributes:
        names: of each dimension.
        low, high: the values of -1 and of 1, in the dataset's units.
    """

    names: tuple[str, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]

    def normalized(self, actions: NDArray) -> NDArray[np.float32]:
        """Actions (..., A) in the dataset's units as float32, low at -1 and high at 1."""
        if self._is_normal():
            return np.asarray(actions, np.float32)  # exactly as they were recorded
        low, high = np.array(self.low), np.array(self.high)
        return (2.0 * (actions - low) / (high - low) - 1.0).astype(np.float32)

    def physical(self, actions: NDArray) -> NDArray[np.float32]:
        """Actions (..., A) in [-1, 1] in the dataset's units, as float32."""
        if self._is_normal():
            return np.asarray(actions, np.float32)
        low, high = np.array(self.low), np.array(self.high)
        return (low + (actions + 1.0) * (high - low) / 2.0).astype(np.float32)

    def _is_normal(self) -> bool:
        return set(self.low) == {-1.0} and set(self.high) == {1.0}
