"""Which of a dataset's dimensions are observation and action, and what models know them by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


def _check_names(column: str, dims: Sequence[str | int], names: Sequence[str]) -> None:
    if dims and names and len(dims) != len(names):
        raise ValueError(f"{column}: found {len(names)} names for {len(dims)} dims")
    for what, given in (("dims", dims), ("names", names)):
        twice = [str(one) for one in dict.fromkeys(given) if list(given).count(one) > 1]
        if twice:
            raise ValueError(f"{column}: {', '.join(twice)} twice under {what}")


@dataclass(frozen=True)
class Part:
    """Dimensions of one column that go into the observation.

    Attributes:
        column: name of the column, e.g. "observation.state".
        dims: which of its dimensions and in which order, by the dataset's names or by number;
            () takes all.
        names: what models know them by, one for each; () keeps the dataset's names.
        unit: the size of a metre or radian in the column's numbers, which are divided by it.
    """

    column: str
    dims: tuple[str | int, ...] = ()
    names: tuple[str, ...] = ()
    unit: float = 1.0

    def __post_init__(self) -> None:
        _check_names(self.column, self.dims, self.names)
        if not self.unit > 0:
            raise ValueError(f"{self.column}: unit must be above 0, found {self.unit}")


@dataclass(frozen=True)
class ActionPart:
    """Dimensions of one column that are the action.

    Attributes:
        column, dims, names: as of `Part`.
        low, high: what -1 and 1 stand for, of every dimension or of each.
    """

    column: str = "action"
    dims: tuple[str | int, ...] = ()
    names: tuple[str, ...] = ()
    low: float | tuple[float, ...] = -1.0
    high: float | tuple[float, ...] = 1.0

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
        return tuple(dict.fromkeys([*(p.column for p in self.observation), self.action.column]))


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
