"""Rows, or pictures, that two datasets have in common, by their hashes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lfr.curation.diff.fingerprints import Hashes

Rows = NDArray[np.int64]
Located = tuple[Hashes, Rows]
"""Hashes (N,), and the episode of each."""


def in_common(a: Located, b: Located) -> tuple[Rows, Rows]:
    """Episodes that have rows in common, and how many: (P, 2) and (P,).

    Only rows that stand in one episode on either side tell: what an arm does at home, or a constant
    column, is in many.
    """
    (hashes_a, episode_a, count_a), (hashes_b, episode_b, count_b) = _telling(*a), _telling(*b)
    _, in_a, in_b = np.intersect1d(hashes_a, hashes_b, assume_unique=True, return_indices=True)
    both = np.stack([episode_a[in_a], episode_b[in_b]], axis=1)
    pairs, number = np.unique(both, axis=0, return_inverse=True)
    rows = np.minimum(count_a[in_a], count_b[in_b])
    return pairs, np.bincount(number.ravel(), rows, len(pairs)).astype(np.int64)


def _telling(hashes: Hashes, episode: Rows) -> tuple[Hashes, Rows, Rows]:
    """The different hashes of one episode alone, that episode, and how often it has each."""
    if not len(hashes):
        return hashes, episode, np.zeros(0, np.int64)
    order = np.argsort(hashes, kind="stable")
    hashes, episode = hashes[order], episode[order]
    start = np.flatnonzero(np.concatenate([[True], hashes[1:] != hashes[:-1]]))
    first, last = (of.reduceat(episode, start) for of in (np.minimum, np.maximum))
    alone = first == last
    count = np.diff(start, append=len(hashes))
    return hashes[start][alone], first[alone], count[alone]


def offset(a: Hashes, b: Hashes) -> int:
    """How many rows of A stand before B's first: where most of their rows in common lie."""
    _, in_a, in_b = np.intersect1d(a, b, return_indices=True)
    if not len(in_a):
        return 0
    steps, counts = np.unique(in_a - in_b, return_counts=True)
    return int(steps[counts.argmax()])


def overlap(offset: int, length_a: int, length_b: int) -> tuple[slice, slice]:
    """The rows of A and of B that stand side by side."""
    rows = max(min(length_a - max(offset, 0), length_b - max(-offset, 0)), 0)
    first_a, first_b = max(offset, 0), max(-offset, 0)
    return slice(first_a, first_a + rows), slice(first_b, first_b + rows)
