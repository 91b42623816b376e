"""Statistics of a feature, exact, in the form of LeRobot's stats.json.

LeRobot 0.6.1 averages the quantiles of episodes, each read off a histogram (issue 4156: q01 of
-1.30 where -10.2 is true). These are taken over all the values at once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}

Stats = dict[str, NDArray]


def vector_stats(values: ArrayLike) -> Stats:
    """Statistics of (N,) or (N, D) values: (D,) float64 each, and `count` (1,) int64.

    The standard deviation is the population's; quantiles interpolate linearly.
    """
    rows = np.asarray(values, dtype=np.float64)
    rows = rows.reshape(len(rows), -1)
    quantiles = np.quantile(rows, list(QUANTILES.values()), axis=0)
    return {
        "min": rows.min(axis=0),
        "max": rows.max(axis=0),
        "mean": rows.mean(axis=0),
        "std": rows.std(axis=0),
        "count": np.array([len(rows)]),
        **dict(zip(QUANTILES, quantiles, strict=True)),
    }


def image_stats(histogram: ArrayLike, frames: int) -> Stats:
    """Statistics of all pixels, (3, 1, 1) in [0, 1] per channel, from (3, 256) counts of values.

    `count` is the number of frames, as in LeRobot.
    """
    counts = np.asarray(histogram, dtype=np.int64)
    levels = np.arange(256) / 255
    pixels = counts.sum(axis=1)
    mean = counts @ levels / pixels
    variance = (counts * (levels - mean[:, None]) ** 2).sum(axis=1) / pixels
    present = [np.flatnonzero(channel) for channel in counts]
    stats = {
        "min": [levels[p[0]] for p in present],
        "max": [levels[p[-1]] for p in present],
        "mean": mean,
        "std": np.sqrt(variance),
    }
    for name, q in QUANTILES.items():
        stats[name] = [_quantile(channel.cumsum(), levels, q) for channel in counts]
    shaped: Stats = {
        name: np.asarray(value, np.float64).reshape(3, 1, 1) for name, value in stats.items()
    }
    shaped["count"] = np.array([frames])
    return shaped


def _quantile(cumulative: NDArray[np.int64], levels: NDArray[np.float64], q: float) -> float:
    """As np.quantile of the sorted pixels, of which `cumulative` counts those up to each level."""
    at = q * (cumulative[-1] - 1)
    low, high = np.searchsorted(cumulative, [np.floor(at), np.ceil(at)], side="right")
    return float(levels[low] + (levels[high] - levels[low]) * (at - np.floor(at)))
