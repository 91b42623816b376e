"""Statistics of all rows and of every episode at once, equal to `lfr.data.stats` on each."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from lfr.curation.contents import with_column
from lfr.data.stats import QUANTILES, Stats, vector_stats

NAMES = ("min", "max", "mean", "std", "count", *QUANTILES)


def dataset_stats(values: NDArray) -> Stats:
    """Of (N,) or (N, D) values: as `lfr.data.stats.vector_stats`, in bounded memory."""
    rows = values.reshape(len(values), -1)
    columns = [vector_stats(rows[:, i]) for i in range(rows.shape[1])]
    joined = {name: np.concatenate([c[name] for c in columns]) for name in columns[0]}
    return {**joined, "count": columns[0]["count"]}


def episode_stats(values: NDArray, lengths: NDArray[np.int64], *, bounds: bool = False) -> Stats:
    """Statistics of each episode: (E, D) float64 each, and `count` (E, 1).

    Args:
        values: (N,) or (N, D), the episodes one after the other.
        lengths: (E,) rows of each, at least 1; their sum is N.
        bounds: with each quantile, as `q01/low` and `q01/high`, what any definition of it lies
            between: the row before its neighbour below, and the one after its neighbour above.
    """
    rows = values.reshape(len(values), -1)
    starts = np.cumsum(lengths) - lengths
    shape = (len(lengths), rows.shape[1])
    names = [name for name in NAMES if name != "count"]
    names += [f"{q}/{end}" for q in QUANTILES for end in ("low", "high")] if bounds else []
    stats: Stats = {name: np.empty(shape) for name in names}
    for length in np.unique(lengths):  # episodes of one length are one array
        chosen = np.flatnonzero(lengths == length)
        part = rows[starts[chosen, None] + np.arange(length)].astype(np.float64)  # (n, L, D)
        stats["mean"][chosen], stats["std"][chosen] = part.mean(axis=1), part.std(axis=1)
        part.sort(axis=1)
        stats["min"][chosen], stats["max"][chosen] = part[:, 0], part[:, -1]
        for name, q in QUANTILES.items():
            stats[name][chosen] = _quantile(part, q)
            if bounds:
                below = int(q * (length - 1))
                stats[f"{name}/low"][chosen] = part[:, max(below - 1, 0)]
                stats[f"{name}/high"][chosen] = part[:, min(below + 2, length - 1)]
    stats["count"] = lengths[:, None]
    return stats


def with_episode_stats(
    table: pa.Table, key: str, values: NDArray, lengths: NDArray[np.int64]
) -> pa.Table:
    """meta/episodes with the columns `stats/<key>/...`, computed from the feature's values."""
    for name, value in episode_stats(values, lengths).items():
        table = with_column(table, f"stats/{key}/{name}", pa.array(value.tolist()))
    return table


def _quantile(ordered: NDArray[np.float64], q: float) -> NDArray[np.float64]:
    """(n, D) of (n, L, D) values in order, interpolated linearly as np.quantile does."""
    at = q * (ordered.shape[1] - 1)
    low = int(at)
    high = min(low + 1, ordered.shape[1] - 1)
    below, above = ordered[:, low], ordered[:, high]
    t = at - low
    return below + (above - below) * t if t < 0.5 else above - (above - below) * (1 - t)


def averaged(stats: NDArray, counts: NDArray) -> NDArray[np.float64]:
    """(D,) mean of the episodes' (E, D) values, weighted by their (E, 1) counts.

    It is what LeRobot 0.6.1 takes the quantiles of a dataset for (its issue 4156).
    """
    return (stats * counts).sum(axis=0) / counts.sum()


def pooled_stats(table: pa.Table, key: str) -> dict[str, Any]:
    """Of pictures, which are not decoded: from the episodes'; quantiles averaged, as LeRobot's."""
    columns = {name: f"stats/{key}/{name}" for name in NAMES}
    there = [n for n, c in columns.items() if c in table.column_names]
    names = [n for n in there if not table[columns[n]].null_count]  # gaps: one dataset has none
    if not {"min", "max", "mean", "std", "count"} <= set(names):
        return {}
    per = {n: np.array(table[columns[n]].to_pylist(), np.float64) for n in names}
    counts = per["count"].reshape(len(table), *[1] * (per["mean"].ndim - 1))
    mean = averaged(per["mean"], counts)
    square = averaged(per["std"] ** 2 + (per["mean"] - mean) ** 2, counts)
    pooled = {name: averaged(per[name], counts) for name in names}
    pooled |= {"min": per["min"].min(axis=0), "max": per["max"].max(axis=0), "std": np.sqrt(square)}
    return {**{n: v.tolist() for n, v in pooled.items()}, "count": [int(counts.sum())]}
