"""The columns that both datasets have, dimension by dimension."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lfr.curation.contents import DEFAULT_FEATURES
from lfr.curation.diff.side import Side


@dataclass(frozen=True)
class Shared:
    """A column of both.

    Attributes:
        key: its name.
        names: of the dimensions that both have, in A's order; empty where it is no numbers.
        a, b: which dimensions of A's and of B's these are; None are all.
    """

    key: str
    names: tuple[str, ...] = ()
    a: tuple[int, ...] | None = None
    b: tuple[int, ...] | None = None

    @property
    def is_numeric(self) -> bool:
        return bool(self.names)

    def named(self, chosen: NDArray[np.bool_]) -> str:
        """The column and those of its dimensions that a mask (D,) names."""
        if chosen.all() or not chosen.any():
            return self.key
        return f"{self.key}: {', '.join(self.names[i] for i in np.flatnonzero(chosen))}"


def shared_columns(a: Side, b: Side) -> tuple[list[Shared], list[str]]:
    """What is compared, with its rows' hashes read; and the columns that cannot be."""
    shared: list[Shared] = []
    apart: list[str] = []
    for key in a.columns:
        if key in DEFAULT_FEATURES or key not in b.columns:
            continue
        found = _shared(key, a, b)
        if found is None:
            apart.append(key)
            continue
        whole = [a.read_hashes(key, found.a), b.read_hashes(key, found.b)]
        shared.append(found if all(whole) else Shared(key))
    return shared, apart


def _shared(key: str, a: Side, b: Side) -> Shared | None:
    sizes = a.size(key), b.size(key)
    if sizes == (None, None):
        return Shared(key)
    if sizes[0] is None or sizes[1] is None:
        return None
    names = a.names(key, sizes[0]), b.names(key, sizes[1])
    if _same_places(*names):
        return Shared(key, tuple(names[0]))
    both = [name for name in names[0] if name in names[1]]
    if not both or any(len(set(each)) < len(each) for each in names):
        return None
    places = [tuple(each.index(name) for name in both) for each in names]
    return Shared(key, tuple(both), places[0], places[1])


def _same_places(a: Sequence[str], b: Sequence[str]) -> bool:
    """Whether as many dimensions have the same places: some may be called otherwise."""
    return len(a) == len(b) and all(
        one == other or (one not in b and other not in a) for one, other in zip(a, b, strict=True)
    )
