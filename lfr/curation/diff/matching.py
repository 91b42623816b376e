"""Which episode of B is which of A: by what is in it, whatever its number."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence

import numpy as np

from lfr.curation.checks.behaviour.signals import correlation
from lfr.curation.diff.columns import Shared
from lfr.curation.diff.fingerprints import digest, joined_hashes
from lfr.curation.diff.in_common import in_common, offset
from lfr.curation.diff.nearly import Tracks, nearly, tracks
from lfr.curation.diff.side import Rows, Side

Pair = tuple[int, int]
"""Positions in A and in B."""

SEED = ("seed", "robot", "task_name")  # a seed alone may be another robot's
SHARE = 0.5  # of the shorter one's rows, or of the dimensions, that must be alike in a changed one
ALIKE = 0.95  # correlation of a dimension over all those episodes


class Matching:
    """Episodes that have been found again, and those that have not yet.

    Attributes:
        pairs: in the order of A.
        offsets: of those whose rows are not the same, how many of A's rows stand before B's first.
        a, b: positions of those without a counterpart.
    """

    def __init__(self, a: Side, b: Side) -> None:
        self._sides = (a, b)
        self.pairs: list[Pair] = []
        self.offsets: dict[Pair, int] = {}
        self.a, self.b = list(range(len(a))), list(range(len(b)))

    def add(self, pairs: Iterable[Pair]) -> None:
        """Take those whose episodes are both still free, the first ones first."""
        free_a, free_b = set(self.a), set(self.b)
        for one, other in pairs:
            if one in free_a and other in free_b:
                free_a.remove(one)
                free_b.remove(other)
                self.pairs.append((one, other))
        self.pairs.sort()
        self.a = [one for one in self.a if one in free_a]
        self.b = [one for one in self.b if one in free_b]

    def by_key(self, of_a: Sequence[Hashable], of_b: Sequence[Hashable], once: bool) -> None:
        """Those with the same key, of one index first; None is no key.

        Args:
            once: only keys that one free episode has on either side.
        """
        groups: dict[Hashable, tuple[list[int], list[int]]] = {}
        for side, (free, keys) in enumerate(((self.a, of_a), (self.b, of_b))):
            for position in free:
                if keys[position] is not None:
                    groups.setdefault(keys[position], ([], []))[side].append(position)
        pairs: list[Pair] = []
        for ones, others in groups.values():
            if not once or len(ones) == len(others) == 1:
                pairs += self._of_group(ones, others)
        self.add(pairs)

    def _of_group(self, ones: list[int], others: list[int]) -> list[Pair]:
        a, b = self._sides
        place = {int(b.episode[other]): other for other in others}
        same = [(one, place[e]) for one in ones if (e := int(a.episode[one])) in place]
        left = [one for one in ones if one not in {pair[0] for pair in same}]
        right = [other for other in others if other not in {pair[1] for pair in same}]
        return same + list(zip(left, right, strict=False))


def matched(a: Side, b: Side, shared: Sequence[Shared]) -> Matching:
    """Find every episode of A in B.

    Those with the same rows and words first, then with the same rows; of the rest those with the
    same seed, with rows in common, with nearly the same rows, with the same index and length.
    """
    found = Matching(a, b)
    if not shared and (a.length.any() or b.length.any()):
        return found
    rows = [_digests(side, shared) for side in (a, b)]
    words = [[(r, digest([side.words[side.rows(p)]])) for p, r in enumerate(of)]
             for side, of in zip((a, b), rows, strict=True)]  # fmt: skip
    found.by_key(*words, once=False)
    found.by_key(*rows, once=False)
    same = set(found.pairs)
    near: dict[Pair, int] = {}
    if found.a and found.b:
        found.by_key(seeds(a, b), seeds(b, a), once=True)
        found.add(_with_rows_in_common(a, b, shared, found))
    if found.a and found.b:
        of = tracks(a, b, shared)
        if of is not None:
            alike = nearly(of[0].only(found.a), of[1].only(found.b))
            near = {(one.a, one.b): one.offset for one in sorted(alike, key=lambda one: -one.rows)}
            found.add(near)
        found.add(_of_index(a, b, found, of))
    for pair in found.pairs:
        if pair not in same:
            found.offsets[pair] = near.get(pair) or _offset(a, b, shared, pair)
    return found


def _offset(a: Side, b: Side, shared: Sequence[Shared], pair: Pair) -> int:
    x, y = (
        joined_hashes([side.hashes[one.key][side.rows(p)] for one in shared], int(side.length[p]))
        for side, p in zip((a, b), pair, strict=True)
    )
    return offset(x, y)


def _digests(side: Side, shared: Sequence[Shared]) -> list[bytes]:
    columns = [side.hashes[one.key] for one in shared]
    return [digest(hashes[side.rows(p)] for hashes in columns) for p in range(len(side))]


def seeds(side: Side, other: Side) -> list[str | None]:
    """Of each episode its seed, and its robot and task where both datasets have them; None where
    it has no seed.
    """
    both = [side.contents.episodes, other.contents.episodes]
    names = [name for name in SEED if all(name in table.column_names for table in both)]
    if SEED[0] not in names:
        return [None] * len(side)
    rows = zip(*(both[0][name].to_pylist() for name in names), strict=True)
    return [None if row[0] is None else str(row) for row in rows]


def _with_rows_in_common(
    a: Side, b: Side, shared: Sequence[Shared], found: Matching
) -> Iterable[Pair]:
    counts: dict[Pair, int] = {}
    free = [np.isin(side.of_row, of) for side, of in ((a, found.a), (b, found.b))]
    episodes: list[Rows] = [side.of_row[mask] for side, mask in zip((a, b), free, strict=True)]
    for one in shared:
        hashes = [side.hashes[one.key][mask] for side, mask in zip((a, b), free, strict=True)]
        pairs, rows = in_common((hashes[0], episodes[0]), (hashes[1], episodes[1]))
        for pair, count in zip(pairs.tolist(), rows.tolist(), strict=True):
            counts[pair[0], pair[1]] = counts.get((pair[0], pair[1]), 0) + count
    enough = [
        pair
        for pair, count in counts.items()
        if count >= SHARE * min(a.length[pair[0]], b.length[pair[1]])
    ]
    return sorted(enough, key=lambda pair: (-counts[pair], pair))


def _of_index(
    a: Side, b: Side, found: Matching, of: tuple[Tracks, Tracks] | None
) -> Sequence[Pair]:
    """Those left with the same index and length, if most episodes have been found, or if these
    move alike: in other units, or with noise.
    """
    place = {(int(b.episode[p]), int(b.length[p])): p for p in found.b}
    keys = {one: (int(a.episode[one]), int(a.length[one])) for one in found.a}
    pairs = [(one, place[key]) for one, key in keys.items() if key in place]
    if len(found.pairs) >= len(found.a):
        return pairs
    if len(pairs) < SHARE * min(len(found.a), len(found.b)) or of is None:
        return []
    x, y = (
        np.concatenate([track.values[side.rows(pair[i])] for pair in pairs])
        for i, (track, side) in enumerate(zip(of, (a, b), strict=True))
    )
    alike = [correlation(one, other) > ALIKE for one, other in zip(x.T, y.T, strict=True)]
    return pairs if np.mean(alike) >= SHARE else []
