"""What differs in episodes that have been found again: rows, words, what meta/episodes says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.curation.checks.order import TOLERANCE_S
from lfr.curation.diff.columns import Shared
from lfr.curation.diff.difference import Difference, EpisodePair
from lfr.curation.diff.features import kept_columns
from lfr.curation.diff.in_common import overlap
from lfr.curation.diff.matching import Matching, Pair
from lfr.curation.diff.side import Side

TIME, TASKS = "timestamp", "tasks"


def compare_episodes(
    a: Side, b: Side, shared: Sequence[Shared], found: Matching
) -> Iterator[Difference]:
    """Those of one dataset alone, and what differs in those of both."""
    for one in found.a:
        yield Difference("dropped", "not in B", ((int(a.episode[one]), None),))
    for other in found.b:
        yield Difference("added", "not in A", ((None, int(b.episode[other])),))
    for pair in found.pairs:
        if a.episode[pair[0]] != b.episode[pair[1]]:
            yield Difference("moved", "another episode_index", named(a, b, pair))
    places = {pair: _place(a, b, found, pair) for pair in found.pairs}
    for pair in found.pairs:
        yield from _ends(a, b, found.offsets.get(pair, 0), pair)
    for one in shared:
        yield from _rows(a, b, one, places)
    if TIME in a.columns and TIME in b.columns:
        yield from _times(a, b, found)
    other_words = set()
    for pair in found.pairs:
        words = _words(a, b, pair, places[pair])
        if words is not None:
            other_words.add(pair)
            yield words
    for column in kept_columns(a):
        if column in kept_columns(b):
            skipped = other_words if column == TASKS else set()
            yield from _column(a, b, column, [p for p in found.pairs if p not in skipped])


def named(a: Side, b: Side, pair: Pair) -> tuple[EpisodePair]:
    """Two episodes by their indices."""
    return ((int(a.episode[pair[0]]), int(b.episode[pair[1]])),)


Place = tuple[slice, slice]


def _place(a: Side, b: Side, found: Matching, pair: Pair) -> Place:
    """The rows of either dataset that are held against each other."""
    lengths = int(a.length[pair[0]]), int(b.length[pair[1]])
    inside = overlap(found.offsets.get(pair, 0), *lengths)
    starts = int(a.start[pair[0]]), int(b.start[pair[1]])
    x, y = (slice(s + i.start, s + i.stop) for s, i in zip(starts, inside, strict=True))
    return x, y


def _ends(a: Side, b: Side, offset: int, pair: Pair) -> Iterator[Difference]:
    lengths = int(a.length[pair[0]]), int(b.length[pair[1]])
    if not offset and lengths[0] == lengths[1]:
        return
    begin = f", from A's row {offset} on" if offset > 0 else ""
    begin = f", {-offset} of them before A's first" if offset < 0 else begin
    yield Difference("length", "other rows at its ends", named(a, b, pair), a=f"{lengths[0]} rows",
                     b=f"{lengths[1]} rows{begin}")  # fmt: skip


def _rows(a: Side, b: Side, one: Shared, places: dict[Pair, Place]) -> Iterator[Difference]:
    values: tuple[NDArray, NDArray] | None = None
    for pair, (x, y) in places.items():
        differ = a.hashes[one.key][x] != b.hashes[one.key][y]
        if not differ.any():
            continue
        column, largest = one.key, None
        if one.is_numeric:
            values = values or (a.all_values(one.key, one.a), b.all_values(one.key, one.b))
            before, after = (v[rows][differ].astype(np.float64)
                             for v, rows in zip(values, (x, y), strict=True))  # fmt: skip
            with np.errstate(invalid="ignore"):
                apart = np.abs(before - after)
            same = (before == after) | (np.isnan(before) & np.isnan(after))
            column = one.named(~same.all(axis=0))
            finite = apart[np.isfinite(apart)]
            largest = float(finite.max()) if finite.size and (finite > 0).any() else None
        yield Difference("changed", "other values", named(a, b, pair), column=column,
                         rows=int(differ.sum()), largest=largest)  # fmt: skip


def _times(a: Side, b: Side, found: Matching) -> Iterator[Difference]:
    """Rows at other times, to the tolerance that LeRobot has; those of stretches count anew."""
    if not found.pairs:
        return
    x, y = (side.all_values(TIME, None)[:, 0].astype(np.float64) for side in (a, b))
    for pair in found.pairs:
        if found.offsets.get(pair) or a.length[pair[0]] != b.length[pair[1]]:
            continue
        before, after = x[a.rows(pair[0])], y[b.rows(pair[1])]
        with np.errstate(invalid="ignore"):
            apart = np.abs(before - after)
        differ = ~(apart <= TOLERANCE_S) & ~(np.isnan(before) & np.isnan(after))
        if differ.any():
            largest = float(np.nanmax(apart)) if np.isfinite(apart).any() else None
            yield Difference("changed", "other times", named(a, b, pair), column=TIME,
                             rows=int(differ.sum()), largest=largest)  # fmt: skip


def _words(a: Side, b: Side, pair: Pair, place: Place) -> Difference | None:
    differ = a.words[place[0]] != b.words[place[1]]
    if not differ.any():
        return None
    return Difference("words", "another task", named(a, b, pair), a=a.said(pair[0]),
                      b=b.said(pair[1]), rows=int(differ.sum()))  # fmt: skip


def _column(a: Side, b: Side, column: str, pairs: Sequence[Pair]) -> Iterator[Difference]:
    ours, theirs = (side.contents.episodes[column].to_pylist() for side in (a, b))
    for pair in pairs:
        before, after = ours[pair[0]], theirs[pair[1]]
        if not _same(before, after):
            yield Difference("meta", "meta/episodes says otherwise", named(a, b, pair),
                             column=column, a=before, b=after)  # fmt: skip


def _same(before: Any, after: Any) -> bool:
    if isinstance(before, str) != isinstance(after, str):
        return False
    return before == after or str(before) == str(after)  # NaN, alone or in a list
