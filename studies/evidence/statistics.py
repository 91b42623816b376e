"""How sure a mean over seeds and starts is, and a difference of two."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lfr.evaluation.success_rate import wilson_interval

RESAMPLES = 10_000
CONFIDENCE = 0.95

Outcomes = NDArray[np.float64]
"""(S, N): 1 for success and 0 for failure, of S seeds from the same N starts."""


class Interval(NamedTuple):
    """A mean and its bounds."""

    mean: float
    low: float
    high: float


def outcomes_of(runs: Sequence[str]) -> Outcomes:
    """One row for each run's string of ones and zeros."""
    return np.array([[float(one) for one in run] for run in runs])


def success(outcomes: Outcomes) -> Interval:
    """The rate over seeds and starts.

    The interval is of seeds and starts resampled, each on its own (Owen 2007), since all seeds meet
    the same starts; where nearly all of them succeed or fail it says too little, so it is never
    narrower than Wilson's of as many starts.
    """
    rate, starts = float(outcomes.mean()), outcomes.shape[1]
    low, high = np.quantile(_resampled(outcomes), _bounds())
    least, most = wilson_interval(round(rate * starts), starts, CONFIDENCE)
    return Interval(rate, min(float(low), least), max(float(high), most))


def difference(first: Outcomes, second: Outcomes) -> Interval:
    """How much higher the first rate is, over the same seeds and starts.

    Both are resampled alike: a seed has the same demonstrations and skill models in either, and a
    start the same difficulty.

    Raises:
        ValueError: other seeds or starts.
    """
    if first.shape != second.shape:
        raise ValueError(f"{first.shape} and {second.shape} are not of the same seeds and starts")
    apart = first - second
    low, high = np.quantile(_resampled(apart), _bounds())
    return Interval(float(apart.mean()), float(low), float(high))


def _resampled(values: Outcomes) -> NDArray[np.float64]:
    """(RESAMPLES,) means with seeds and starts drawn anew, with replacement."""
    of_seeds, of_starts = _weights(*values.shape)
    return ((of_seeds @ values) * of_starts).sum(axis=1) / values.size


@cache
def _weights(seeds: int, starts: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(RESAMPLES, S) and (RESAMPLES, N): how often each seed and each start is drawn."""
    random = np.random.default_rng(0)
    return (
        random.multinomial(seeds, np.full(seeds, 1 / seeds), RESAMPLES).astype(np.float64),
        random.multinomial(starts, np.full(starts, 1 / starts), RESAMPLES).astype(np.float64),
    )


def _bounds() -> tuple[float, float]:
    return (1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2
