"""Where a dimension's values have moved, in standard deviations; and units, told from values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lfr.curation.diff.columns import Shared
from lfr.curation.diff.difference import Difference
from lfr.curation.diff.side import Side

STATISTICS = "statistics"
MOVED = 0.01  # standard deviations of A
UNITS = {
    180 / np.pi: "degrees where it is radians",
    100.0: "centimetres or percent where it is metres or parts of 1",
    255.0: "0 to 255 where it is 0 to 1",
    1000.0: "millimetres where it is metres",
}
"""How many times larger numbers of the same may be, and why."""
NEAR = 0.2  # of the logarithm of such a factor; 0.25 of 180 / pi is what 45 is

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Moments:
    """(D,) each, over the finite values of a column; a count of 0 leaves the others 0."""

    count: Array
    mean: Array
    std: Array


def compare_statistics(a: Side, b: Side, shared: Sequence[Shared]) -> Iterator[Difference]:
    """Units first, then the dimensions that have moved, the furthest first."""
    moved: list[tuple[float, Difference]] = []
    for one in shared:
        if not one.is_numeric or not a.length.any() or not b.length.any():
            continue
        x, y = moments(a, one.key, one.a), moments(b, one.key, one.b)
        other = np.zeros(len(x.mean), bool)
        for found, mask in _units(one, x, y):
            yield found
            other |= mask
        there = (x.count > 0) & (y.count > 0) & ~other
        scale = np.where(x.std > 0, x.std, np.inf)
        apart = np.maximum(np.abs(y.mean - x.mean), np.abs(y.std - x.std))
        far = np.where(x.std > 0, apart / scale, np.where(apart > 0, np.inf, 0.0))
        for i in np.flatnonzero(there & (far > MOVED)):
            column = one.key if len(one.names) == 1 else f"{one.key}: {one.names[i]}"
            how = "constant in A" if x.std[i] == 0 else f"by {far[i]:.3g} standard deviations"
            moved.append((float(far[i]), Difference(
                STATISTICS, f"moved, {how}", column=column,
                a=f"{x.mean[i]:.4g} ± {x.std[i]:.4g}", b=f"{y.mean[i]:.4g} ± {y.std[i]:.4g}",
            )))  # fmt: skip
    moved.sort(key=lambda each: -each[0])
    yield from (difference for _, difference in moved)


def moments(side: Side, column: str, dims: Sequence[int] | None) -> Moments:
    """Of a column of numbers, in one pass (Chan, Golub, LeVeque 1979)."""
    count, mean, square = (np.zeros(1) for _ in range(3))
    for batch in side.values(column, dims):
        values = batch.astype(np.float64)
        finite = np.isfinite(values)
        n = finite.sum(axis=0)
        m = np.where(finite, values, 0.0).sum(axis=0) / np.maximum(n, 1)
        s = np.square(np.where(finite, values - m, 0.0)).sum(axis=0)
        whole = np.maximum(count + n, 1)
        square = square + s + np.square(m - mean) * count * n / whole
        mean = np.where(n > 0, mean + (m - mean) * n / whole, mean)
        count = count + n
    return Moments(count, mean, np.sqrt(square / np.maximum(count, 1)))


def _units(one: Shared, a: Moments, b: Moments) -> Iterator[tuple[Difference, NDArray[np.bool_]]]:
    """Dimensions whose spread, and whose size too, differ by the factor of two units."""
    live = (a.std > 0) & (b.std > 0)
    size = [np.sqrt(np.square(of.mean) + np.square(of.std)) for of in (a, b)]
    spread = np.log(np.where(live, b.std, 1) / np.where(live, a.std, 1))
    reach = np.log(np.where(live, size[1], 1) / np.where(live, size[0], 1))
    for factor, words in UNITS.items():
        for sign, (larger, smaller) in ((1, ("B", "A")), (-1, ("A", "B"))):
            wanted = sign * np.log(factor)
            mask = live & (np.abs(spread - wanted) < NEAR) & (np.abs(reach - wanted) < NEAR)
            if mask.any():
                times = float(np.exp(np.median(np.abs(spread[mask]))))
                yield Difference(
                    "unit", f"{times:.3g} times larger in {larger}: {words} in {smaller}?",
                    column=one.named(mask),
                ), mask  # fmt: skip
