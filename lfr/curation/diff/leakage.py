"""What a training set, A, and a test set, B, share: each pair of episodes once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from lfr.curation.checks.seeds import EXPECTED, OURS
from lfr.curation.diff.columns import Shared
from lfr.curation.diff.difference import Difference
from lfr.curation.diff.episodes import named
from lfr.curation.diff.fingerprints import Hashes, digest, joined_hashes
from lfr.curation.diff.in_common import in_common
from lfr.curation.diff.matching import Pair, seeds
from lfr.curation.diff.nearly import nearly, tracks
from lfr.curation.diff.packets import Camera
from lfr.curation.diff.side import Rows, Side
from lfr.curation.finding import Unreadable, short
from lfr.data.episode import ACTION
from lfr.errors import LfrError
from lfr.seeds import use_of_seed

TWO = 2  # rows, or key frames, in common: one may be a start
HALF, VECTOR = 0.5, 3  # of the shorter episode's rows, in a column of so many numbers or more
HOME = 0.5  # of the episodes of either set: a start that so many have is the arm's, no leak


class Leaks:
    """Pairs of episodes that have been named, each once."""

    def __init__(self, a: Side, b: Side) -> None:
        self._sides, self._named = (a, b), set[Pair]()

    def take(
        self, kind: str, message: str, pairs: Iterator[tuple[Pair, int]], column: str | None = None
    ) -> Iterator[Difference]:
        """One for each pair that is new, with the number of rows that both have, or 0."""
        for pair, rows in pairs:
            if pair not in self._named:
                self._named.add(pair)
                yield Difference(kind, message, named(*self._sides, pair), column, rows=rows)


def find_leaks(
    a: Side, b: Side, shared: Sequence[Shared], pictures: bool, not_compared: list[str]
) -> Iterator[Difference]:
    """All of them.

    Args:
        shared: the columns of both.
        pictures: whether to read the videos, for key frames that both have.
        not_compared: is added to where something cannot be judged.
    """
    leaks = Leaks(a, b)
    told = [one for one in shared if one.key == ACTION
            or one.key.startswith((f"{ACTION}.", "observation."))]  # fmt: skip
    told = [one for one in told if one.is_numeric] or told
    if told:
        yield from _rows(a, b, told, leaks)
    else:
        not_compared.append("rows (no column of observations or actions in common)")
    if pictures:
        for key in a.contents.pictures():
            if key in b.contents.pictures():
                found = (_key_frames(side, key, not_compared) for side in (a, b))
                yield from leaks.take("same-pictures", "key frames in common", _several(*found))
    if starts := [one for one in told if one.key != ACTION and one.is_numeric]:
        yield from leaks.take("same-start", "the same first row",
                              _starts(a, b, starts, not_compared))  # fmt: skip
    yield from leaks.take("same-seed", "the same seed", _seeds(a, b))
    yield from _leaked_seeds(a)


def _rows(a: Side, b: Side, told: Sequence[Shared], leaks: Leaks) -> Iterator[Difference]:
    rows = _joined(a, told), _joined(b, told)
    yield from leaks.take("identical", "the same episode", _identical(a, b, rows))
    both = _several(_of_rows(a, rows[0]), _of_rows(b, rows[1]))
    yield from leaks.take("shared-rows", "rows in common", both)
    if of := tracks(a, b, told):
        near = (((one.a, one.b), one.rows) for one in nearly(*of))
        yield from leaks.take("nearly-identical", "nearly the same rows", near)
    for one in told:
        if len(one.names) >= VECTOR:
            found = _several(*(_of_rows(side, side.hashes[one.key]) for side in (a, b)))
            most = (((x, y), count) for (x, y), count in found
                    if count >= HALF * min(a.length[x], b.length[y]))  # fmt: skip
            yield from leaks.take("shared-column", "rows of a column in common", most, one.key)


def _joined(side: Side, columns: Sequence[Shared]) -> Hashes:
    hashes = [side.hashes[one.key] for one in columns]
    return joined_hashes(hashes, len(hashes[0]))


def _of_rows(side: Side, hashes: Hashes) -> tuple[Hashes, Rows]:
    inside = side.of_row >= 0
    return hashes[inside], side.of_row[inside]


def _identical(a: Side, b: Side, rows: Sequence[Hashes]) -> Iterator[tuple[Pair, int]]:
    known: dict[bytes, list[int]] = {}
    for one in np.flatnonzero(a.length).tolist():
        known.setdefault(digest([rows[0][a.rows(one)]]), []).append(one)
    for other in np.flatnonzero(b.length).tolist():
        for one in known.get(digest([rows[1][b.rows(other)]]), ()):
            yield (one, other), int(a.length[one])


def _key_frames(side: Side, key: str, not_compared: list[str]) -> tuple[Hashes, Rows]:
    camera = Camera(side, key)
    side.contents.source.fetch("videos")
    hashes: list[Hashes] = [np.zeros(0, np.uint64)]
    episodes: list[Rows] = [np.zeros(0, np.int64)]
    for position in range(len(side)):
        try:
            keys = camera.stretch(position).keys
        except Unreadable as error:
            line = short(f"{key} ({error.finding.message}: {error.finding.file})")
            if line not in not_compared:
                not_compared.append(line)
            continue
        hashes.append(keys)
        episodes.append(np.full(len(keys), position))
    return np.concatenate(hashes), np.concatenate(episodes)


def _several(a: tuple[Hashes, Rows], b: tuple[Hashes, Rows]) -> Iterator[tuple[Pair, int]]:
    """Episodes with rows, or key frames, in common."""
    pairs, counts = in_common(a, b)
    for (one, other), count in zip(pairs.tolist(), counts.tolist(), strict=True):
        if count >= TWO:
            yield (one, other), count


def _starts(
    a: Side, b: Side, columns: Sequence[Shared], not_compared: list[str]
) -> Iterator[tuple[Pair, int]]:
    """Equal first rows of all that is observed, but for one that most episodes have."""
    first: list[dict[int, list[int]]] = []
    for side in (a, b):
        some = np.flatnonzero(side.length)
        starts = joined_hashes(
            [side.hashes[one.key][side.start[some]] for one in columns], len(some)
        )
        found: dict[int, list[int]] = {}
        for position, start in zip(some.tolist(), starts.tolist(), strict=True):
            found.setdefault(start, []).append(position)
        first.append(found)
    for start, ones in first[0].items():
        others = first[1].get(start, [])
        many = [len(group) > max(2, HOME * len(side)) for group, side in ((ones, a), (others, b))]
        if others and any(many):
            not_compared.append("starts (most episodes have the same)")
            continue
        for one in ones:
            for other in others:
                yield (one, other), 0


def _seeds(a: Side, b: Side) -> Iterator[tuple[Pair, int]]:
    known: dict[object, list[int]] = {}
    for one, seed in enumerate(seeds(a, b)):
        if seed is not None:
            known.setdefault(seed, []).append(one)
    for other, seed in enumerate(seeds(b, a)):
        for one in known.get(seed, ()):
            yield (one, other), 0


def _leaked_seeds(a: Side) -> Iterator[Difference]:
    """Demonstrations from starts that policies are judged on."""
    if not set(a.contents.episodes.column_names) >= OURS:
        return
    for position, seed in enumerate(a.contents.episodes["seed"].to_pylist()):
        try:
            use = use_of_seed(seed) if isinstance(seed, int) else "demonstration"
        except LfrError:
            use = "no"
        if use != "demonstration":
            message = f"a seed of {use} episodes in A, expected {EXPECTED}"
            episodes = ((int(a.episode[position]), None),)
            yield Difference("leaked-seed", message, episodes, column="seed", a=seed)
