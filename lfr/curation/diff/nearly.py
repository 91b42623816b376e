"""Episodes nearly alike: no row further apart than a hundredth of what a dimension spans.

They may be shifted, or one a stretch of the other. Each episode's fastest rows, one of either half,
are looked up among all rows of the other dataset by a k-d tree; what is found is compared row by
row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lfr.curation.checks.behaviour.episodes import NEARLY
from lfr.curation.checks.behaviour.signals import Signal
from lfr.curation.contents import runs
from lfr.curation.diff.columns import Shared
from lfr.curation.diff.in_common import overlap
from lfr.curation.diff.side import Side
from lfr.data.episode import ACTION

LEAST = 5  # rows, of which two stretches must be to be nearly alike
HALF = 0.5  # of the shorter episode, that must lie within the other
ROWS = 0.95  # of these, that must be near
PROBES = 8  # rows that are compared first

Array = NDArray[np.float32]
Rows = NDArray[np.int64]


@dataclass(frozen=True)
class Tracks:
    """What was observed and done, each dimension in what it spans in A.

    Attributes:
        values: (N, D).
        position: (E,) of each episode, in meta/episodes.
        start, length: (E,) its rows.
    """

    values: Array
    position: Rows
    start: Rows
    length: Rows

    def only(self, positions: Sequence[int]) -> Tracks:
        chosen = np.isin(self.position, list(positions))
        return replace(self, position=self.position[chosen], start=self.start[chosen],
                       length=self.length[chosen])  # fmt: skip


@dataclass(frozen=True)
class Near:
    """Two episodes, by their positions: row `offset` of A's is the first of B's, over `rows`."""

    a: int
    b: int
    offset: int
    rows: int


def tracks(a: Side, b: Side, shared: Sequence[Shared]) -> tuple[Tracks, Tracks] | None:
    """Of the columns of numbers that were observed or done; None where there are none that move."""
    if not a.length.any() or not b.length.any():
        return None
    parts: tuple[list[Array], list[Array]] = ([], [])
    there = runs(a.contents)
    for one in shared:
        told = one.key == ACTION or one.key.startswith((f"{ACTION}.", "observation."))
        if not told or not one.is_numeric:
            continue
        x, y = (_finite(side.all_values(one.key, of)) for side, of in ((a, one.a), (b, one.b)))
        spread = Signal(one.key, one.names, x, there).spread
        for part, values in zip(parts, (x, y), strict=True):
            scaled = values[:, spread > 0] / spread[spread > 0]
            part.append(np.clip(scaled, -1e6, 1e6).astype(np.float32))
    if not any(part.shape[1] for part in parts[0]):
        return None
    return _tracks(a, parts[0]), _tracks(b, parts[1])


def _tracks(side: Side, parts: list[Array]) -> Tracks:
    some = np.flatnonzero(side.length)
    return Tracks(np.concatenate(parts, axis=1), some, side.start[some], side.length[some])


def _finite(values: NDArray) -> NDArray[np.float64]:
    return np.nan_to_num(values.astype(np.float64), posinf=0.0, neginf=0.0)


def nearly(a: Tracks, b: Tracks) -> list[Near]:
    """All pairs of episodes that are nearly alike, once each, where most of their rows are."""
    found: dict[tuple[int, int], Near] = {}
    of_a = _found(b, a)
    of_b = [replace(one, a=one.b, b=one.a, offset=-one.offset) for one in _found(a, b)]
    for one in of_a + of_b:
        before = found.get((one.a, one.b))
        if before is None or before.rows < one.rows:
            found[one.a, one.b] = one
    return sorted(found.values(), key=lambda one: (one.a, one.b))


def _found(few: Tracks, many: Tracks) -> list[Near]:
    """Episodes of `few` among the rows of `many`, which is A here."""
    from scipy.spatial import KDTree

    if not len(few.start) or not len(many.start):
        return []
    rows = np.concatenate(
        [np.arange(s, s + n) for s, n in zip(many.start, many.length, strict=True)]
    )
    owner = np.repeat(np.arange(len(many.start)), many.length)
    radius = NEARLY * np.sqrt(many.values.shape[1])
    tree = KDTree(many.values[rows])
    episode, anchor = _anchors(few)
    hits = tree.query_ball_point(few.values[anchor], radius, return_sorted=False)
    candidates: set[tuple[int, int, int]] = set()  # episode of few, of many, offset
    for e, at, hit in zip(episode.tolist(), anchor.tolist(), hits, strict=True):
        if not hit:
            continue
        near = np.array(hit)
        apart = np.square(many.values[rows[near]] - few.values[at]).sum(axis=1)
        near = near[np.lexsort((apart, owner[near]))]
        _, first = np.unique(owner[near], return_index=True)  # the nearest row of each episode
        for row in near[first].tolist():
            other = int(owner[row])
            offset = int(rows[row] - many.start[other]) - int(at - few.start[e])
            candidates.add((e, other, offset))
    return [near for e, other, offset in sorted(candidates)
            if (near := _compared(few, many, e, other, offset)) is not None]  # fmt: skip


def _anchors(few: Tracks) -> tuple[Rows, Rows]:
    """Episode and row of the fastest step in each half of each episode."""
    steps = np.square(np.diff(few.values, axis=0, prepend=few.values[:1])).sum(axis=1)
    found: list[tuple[int, int]] = []
    for e, (start, length) in enumerate(zip(few.start.tolist(), few.length.tolist(), strict=True)):
        middle, end = start + (length + 1) // 2, start + length
        for first, last in ((start + 1, middle), (middle, end)):  # none leads to the first row
            if first < last:
                found.append((e, first + int(steps[first:last].argmax())))
    pairs = np.array(found, np.int64).reshape(-1, 2)
    return pairs[:, 0], pairs[:, 1]


def _compared(few: Tracks, many: Tracks, e: int, other: int, offset: int) -> Near | None:
    lengths = int(many.length[other]), int(few.length[e])
    in_many, in_few = overlap(offset, *lengths)
    rows = in_many.stop - in_many.start
    if rows < max(LEAST, HALF * min(lengths)):
        return None
    first_many, first_few = int(many.start[other]) + in_many.start, int(few.start[e]) + in_few.start
    for places in (
        np.unique(np.linspace(0, rows - 1, PROBES).round().astype(int)),
        np.arange(rows),
    ):
        apart = many.values[first_many + places] - few.values[first_few + places]
        near = np.sqrt(np.square(apart).mean(axis=1)) < NEARLY
        if near.mean() < ROWS if len(places) == rows else near.sum() < len(places) - 1:
            return None
    return Near(int(many.position[other]), int(few.position[e]), offset, rows)
