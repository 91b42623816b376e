"""What an action is to what is observed: where it is commanded to go, by how much, or a copy.

copy      x[t] = a[t], or x[t] = a[t - 1]: what was commanded stands among what is measured
position  x[t + 1] is near a[t], in its own unit: the action says where to go
change    x[t + 1] - x[t] follows s a[t]: it says by how much, or how fast
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Kind = Literal["copy", "previous", "position", "change"]
Array = NDArray[np.float64]

EXACT = 1e-6  # of a number's range
LEAST: dict[Kind, float] = {"position": 0.9, "change": 0.5}  # of what varies, that is explained


@dataclass(frozen=True)
class Relation:
    """How one number of the action and one that is observed belong together.

    Attributes:
        action: which number of the action.
        column, place: which number is observed.
        kind: see above; "previous" is a copy of the action of the row before.
        explained: share of its variance that the relation explains.
        scale: of a change, its size for an action of 1.
    """

    action: int
    column: str
    place: int
    kind: Kind
    explained: float = 1.0
    scale: float = 1.0


def relations(
    action: Array, observed: Mapping[str, Array], episodes: NDArray[np.integer]
) -> list[Relation]:
    """Every copy, and for each number of the action what it commands best, if anything.

    Args:
        action: (N, A), row by row.
        observed: columns (N, n).
        episodes: (N,) the number of each row's episode: nothing follows across its end.
    """
    follows = episodes[1:] == episodes[:-1]
    found: list[Relation] = []
    for a in range(action.shape[1]):
        given = action[:, a]
        span = float(np.ptp(given))
        if not span > 0:  # it never changes, so nothing can be told of it
            continue
        commanded: list[Relation] = []
        for column, values in observed.items():
            for place in range(values.shape[1]):
                one = _relation(a, given, span, column, place, values[:, place], follows)
                if one is not None:
                    (found if one.kind in ("copy", "previous") else commanded).append(one)
        order = ("position", "change")
        commanded.sort(key=lambda one: (order.index(one.kind), -one.explained))
        found += commanded[:1]
    return found


def _relation(
    a: int,
    given: Array,
    span: float,
    column: str,
    place: int,
    values: Array,
    follows: NDArray[np.bool_],
) -> Relation | None:
    if np.abs(values - given).max() <= EXACT * span:
        return Relation(a, column, place, "copy")
    before, after, told = values[:-1][follows], values[1:][follows], given[:-1][follows]
    if len(told) < 2 or not np.ptp(values) > 0:
        return None
    if np.abs(after - told).max() <= EXACT * span:
        return Relation(a, column, place, "previous")
    explained = 1.0 - float(np.mean((after - told) ** 2)) / max(float(np.var(after)), 1e-300)
    if explained >= LEAST["position"]:
        return Relation(a, column, place, "position", explained)
    change, square = after - before, float(np.mean(told**2))
    spread = float(np.mean(change**2))
    if not (square > 0 and spread > 0):
        return None
    scale = float(np.mean(change * told)) / square
    explained = 1.0 - float(np.mean((change - scale * told) ** 2)) / spread
    if explained >= LEAST["change"]:
        return Relation(a, column, place, "change", explained, scale)
    return None
