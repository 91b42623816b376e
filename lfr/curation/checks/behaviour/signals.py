"""The numbers of a dataset over time: what a robot observed and did, episode by episode."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.curation.contents import Contents, Runs, runs
from lfr.curation.finding import Finding, Unreadable
from lfr.data.episode import ACTION
from lfr.data.features import names_of

Array = NDArray[np.floating]
Rows = NDArray[np.int64]


@dataclass(frozen=True)
class Signal:
    """A feature whose numbers change over time.

    Attributes:
        key: the feature.
        names: of its dimensions.
        values: (N, D), finite.
        there: the episodes.
    """

    key: str
    names: tuple[str, ...]
    values: Array
    there: Runs

    @cached_property
    def steps(self) -> Array:
        """(N, D) how far each row is from the one before; 0 where an episode begins."""
        steps = np.abs(np.diff(self.values, axis=0, prepend=self.values[:1]))
        steps[self.there.start] = 0.0
        return steps

    @cached_property
    def same(self) -> NDArray[np.bool_]:
        """(N, D) whether a value is exactly the one before; False where an episode begins."""
        same = self.steps == 0.0
        same[self.there.start] = False
        return same

    @cached_property
    def spread(self) -> Array:
        """(D,) from the lowest to the highest that the middle four in five episodes reach."""
        return np.quantile(self.highest, 0.9, axis=0) - np.quantile(self.lowest, 0.1, axis=0)

    @cached_property
    def moving(self) -> NDArray[np.bool_]:
        """(D,) dimensions that go somewhere, in more than a few steps: no constants, no noise, no
        switches.
        """
        usual = np.median(self.steps, axis=0)
        levels = np.array([len(np.unique(column)) for column in self.values[:20_000].T])
        return (self.spread > 0.0) & (usual < 0.1 * self.spread) & (levels > MOST_LEVELS)

    @cached_property
    def lowest(self) -> Array:
        """(E, D) of each episode."""
        return np.minimum.reduceat(self.values, self.there.start, axis=0)

    @cached_property
    def highest(self) -> Array:
        """(E, D) of each episode."""
        return np.maximum.reduceat(self.values, self.there.start, axis=0)

    def of_episodes(self, values: Array) -> Array:
        """(E, D) means of (N, D) over each episode."""
        sums = np.add.reduceat(values, self.there.start, axis=0, dtype=np.float64)
        return sums / self.there.length[:, None]

    def named(self, dimensions: Any) -> str:
        """The feature and the names of some of its dimensions, a mask (D,) or numbers."""
        chosen = np.arange(len(self.names))[dimensions]
        if len(chosen) == len(self.names) or not len(chosen):
            return self.key
        return f"{self.key}: {', '.join(self.names[i] for i in chosen)}"


MOST_LEVELS = 12
"""A dimension with no more values than this is a switch, such as a gripper's command."""


def signals(contents: Contents) -> list[Signal]:
    """What was observed and done, as far as it is vectors of finite numbers."""
    return list(_signals(contents))


def _signals(contents: Contents) -> Iterator[Signal]:
    there = runs(contents)
    if not len(there.start):
        return
    for key in contents.numeric():
        if not (key == ACTION or key.startswith((f"{ACTION}.", "observation."))):
            continue
        try:
            values = contents.column(key)
        except Unreadable:  # said by the check of values
            continue
        rows = values.reshape(len(values), -1)
        if rows.dtype.kind != "f" or rows.shape[1] != contents.features[key]["shape"][0]:
            continue
        if not np.isfinite(rows).all():
            continue
        names = names_of(contents.features[key])
        if len(names) != rows.shape[1]:
            names = [str(i) for i in range(rows.shape[1])]
        yield Signal(key, tuple(names), rows, there)


@dataclass(frozen=True)
class Pair:
    """A state and an action whose dimensions have the same names.

    Attributes:
        state, action: the two features, (N, D) over the dimensions that both have.
    """

    state: Signal
    action: Signal


def paired(found: list[Signal]) -> Pair | None:
    """The state beside the action; None where no dimension is called alike in both."""
    by_key = {signal.key: signal for signal in found}
    action, state = by_key.get(ACTION), by_key.get("observation.state")
    if action is None or state is None or action.names[0].isdigit():
        return None
    both = [name for name in action.names if name in state.names]
    if not both or len(set(both)) != len(both):
        return None
    return Pair(*(_only(signal, both) for signal in (state, action)))


def _only(signal: Signal, names: list[str]) -> Signal:
    places = [signal.names.index(name) for name in names]
    return Signal(signal.key, tuple(names), signal.values[:, places], signal.there)


def stretches(mask: NDArray[np.bool_]) -> tuple[Rows, Rows]:
    """Where the true values of a mask (N,) begin, and how many there are in a row."""
    edges = np.diff(mask.astype(np.int8), prepend=0, append=0)
    start = np.flatnonzero(edges == 1)
    return start, np.flatnonzero(edges == -1) - start


def warning(
    contents: Contents, there: Runs, episode: int, check: str, message: str, *,
    column: str, first: int | None = None, last: int | None = None, **more: Any,
) -> Finding:  # fmt: skip
    """A finding about frames of an episode.

    Args:
        episode: its place among the runs of rows.
        first, last: rows over all episodes; None is the episode's first, or its last.
        more: ``found``, ``expected``; of several episodes or rows ``places``, ``episodes``.
    """
    begin = int(there.start[episode])
    first = begin if first is None else int(first)
    last = begin + int(there.length[episode]) - 1 if last is None else int(last)
    return Finding(check, message, "warning", **contents.place(first), column=column,
                   frames=(first - begin, last - begin), **more)  # fmt: skip


def apart(values: Array, times: float) -> NDArray[np.bool_]:
    """Which of (E, ...) lie more than ``times`` as far from the median as the middle half does."""
    middle = np.median(values, axis=0)
    quarter = np.median(np.abs(values - middle), axis=0)
    return np.abs(values - middle) > times * np.maximum(quarter, 1e-12)


def correlation(first: Array, second: Array) -> float:
    """Pearson's, of arrays of one shape; 0 where one of them is constant."""
    a, b = first - first.mean(), second - second.mean()
    scale = float(np.sqrt((a**2).sum() * (b**2).sum()))
    return float((a * b).sum()) / scale if scale > 0 else 0.0
