"""What several seeds say together: rliable's statistics of success rates.

The definitions are those of Agarwal et al. 2021, "Deep Reinforcement Learning at the Edge of the
Statistical Precipice", and of its library, google-research/rliable. A task is a transfer; a seed is
a whole repetition, from the split of the demonstrations to the end of learning.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from scipy.stats import trim_mean

from lfr.evaluation.statistics import wilson_interval

RESAMPLES = 10_000
GENERATOR_SEED = 0  # the same results, the same intervals, to the last bit

Statistic = Callable[[np.ndarray], np.ndarray]
Place = Literal["below", "level", "above"]


@dataclass(frozen=True)
class Seeds:
    """One task's successes: each of N seeds in its own number of held-out episodes.

    Attributes:
        successes, episodes: (N,) each.
    """

    successes: tuple[int, ...]
    episodes: tuple[int, ...]

    def __post_init__(self) -> None:
        if not self.successes or len(self.successes) != len(self.episodes):
            raise ValueError(f"{len(self.successes)} and {len(self.episodes)} seeds")
        pairs = zip(self.successes, self.episodes, strict=True)
        if any(not 0 <= found <= tried or tried == 0 for found, tried in pairs):
            raise ValueError(f"{self.successes} successes of {self.episodes} episodes")

    @property
    def rates(self) -> np.ndarray:
        """(N,)"""
        return np.array(self.successes) / np.array(self.episodes)


@dataclass(frozen=True)
class Interval:
    """An estimate with the bounds of its interval of 95 %."""

    value: float
    low: float
    high: float

    def beside(self, other: Interval) -> Place:
        """Where this one lies: apart from the other, below or above it, or overlapping, level."""
        return "below" if self.high < other.low else "above" if self.low > other.high else "level"


def mean(rates: np.ndarray) -> np.ndarray:
    """The mean over the last axis, (..., N) -> (...)."""
    return np.mean(rates, axis=-1)


def interquartile_mean(rates: np.ndarray) -> np.ndarray:
    """The mean without the lowest and the highest quarter, (..., N) -> (...).

    A quarter of N is rounded down, as in rliable: of five seeds the middle three count, of three
    all of them.
    """
    return np.asarray(trim_mean(rates, 0.25, axis=-1))


def bootstrap(
    tasks: Sequence[Seeds],
    statistic: Statistic = interquartile_mean,
    resamples: int = RESAMPLES,
    confidence: float = 0.95,
) -> Interval:
    """A statistic of all rates of one or several tasks, with a stratified bootstrap interval.

    What is resampled: within each task by itself (the strata), as many seeds as there are, with
    replacement; and for each seed drawn, its episodes with replacement, so its successes are
    binomial with its observed rate. The interval is between the percentiles. Tasks are not
    resampled: they are the ones we speak of, not a sample. An observed rate varies by its episodes
    already, so drawing these again makes the interval wider than rliable's, never narrower; with
    one seed it is the interval of its episodes alone.

    That is not enough near 0 and 1: a seed that succeeded in every episode does so in every
    resample, and where all but one did, the interquartile mean hardly ever moves. Nor is it where
    seeds agree: all of them meet the same held-out starts, so more seeds tell no more about other
    starts. So neither end is nearer than that of the Wilson interval of the same value over as many
    episodes as there are starts, those of one seed.
    """
    return _bootstrap(tuple(tasks), statistic, resamples, confidence)


@lru_cache(maxsize=4096)  # tables, figures and text ask for the same ones
def _bootstrap(
    tasks: tuple[Seeds, ...], statistic: Statistic, resamples: int, confidence: float
) -> Interval:
    value = float(statistic(np.concatenate([task.rates for task in tasks])))
    generator = np.random.default_rng(GENERATOR_SEED)
    drawn = [_resampled(task, resamples, generator) for task in tasks]
    found = _between_percentiles(value, statistic(np.concatenate(drawn, axis=-1)), confidence)
    starts = sum(max(task.episodes) for task in tasks)
    low, high = wilson_interval(round(value * starts), starts, confidence)
    return Interval(value, min(found.low, low), max(found.high, high))


def difference(
    x: Sequence[Seeds],
    y: Sequence[Seeds],
    resamples: int = RESAMPLES,
    confidence: float = 0.95,
) -> Interval:
    """The mean rate of X less that of Y over all tasks, with a stratified bootstrap interval.

    Both are resampled as in `bootstrap`, each by itself: seeds within a task, and their episodes.
    """
    return _difference(tuple(x), tuple(y), resamples, confidence)


@lru_cache(maxsize=4096)
def _difference(
    x: tuple[Seeds, ...], y: tuple[Seeds, ...], resamples: int, confidence: float
) -> Interval:
    generator = np.random.default_rng(GENERATOR_SEED)
    (mine, drawn), (other, also) = (
        (
            mean(np.concatenate([task.rates for task in tasks])),
            mean(np.concatenate([_resampled(task, resamples, generator) for task in tasks], -1)),
        )
        for tasks in (x, y)
    )
    return _between_percentiles(float(mine - other), drawn - also, confidence)


def over_seeds(
    values: np.ndarray,
    statistic: Statistic = interquartile_mean,
    resamples: int = 2_000,
    confidence: float = 0.95,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A statistic at each of P points of N seeds' curves, and the bounds of its interval.

    Whole curves are resampled, with replacement; nothing within a curve is.

    Args:
        values: (P, N).

    Returns:
        the statistic, the lower and the upper bounds, (P,) each.
    """
    generator = np.random.default_rng(GENERATOR_SEED)
    count = values.shape[1]
    drawn = statistic(values[:, generator.integers(count, size=(resamples, count))])  # (P, R)
    tail = (1.0 - confidence) / 2.0
    low, high = np.quantile(drawn, (tail, 1.0 - tail), axis=-1)
    return statistic(values), low, high


def probability_of_improvement(x: Sequence[np.ndarray], y: Sequence[np.ndarray]) -> float:
    """P(X > Y) of a seed of X against a seed of Y, ties counting half, mean over tasks.

    On one task it is the Mann-Whitney statistic divided by the number of pairs.

    Args:
        x, y: for each task the rates of all seeds, (N,) and (M,).
    """
    each = [_wins(mine, other).mean() for mine, other in zip(x, y, strict=True)]
    return float(np.mean(each))


def improvement(
    x: Sequence[Seeds],
    y: Sequence[Seeds],
    resamples: int = RESAMPLES,
    confidence: float = 0.95,
) -> Interval:
    """The probability of improvement of method X over Y, with a stratified bootstrap interval.

    Seeds alone are resampled, of both methods and within each task, as rliable does: ranks change
    when episodes are drawn once more, and the middle of the interval would no longer be the
    estimate.
    """
    generator = np.random.default_rng(GENERATOR_SEED)
    drawn = np.zeros(resamples)
    for mine, other in zip(x, y, strict=True):
        wins = _wins(mine.rates, other.rates)
        rows, columns = (generator.integers(n, size=(resamples, n)) for n in wins.shape)
        drawn += wins[rows[:, :, None], columns[:, None, :]].mean(axis=(1, 2)) / len(x)
    value = probability_of_improvement([one.rates for one in x], [one.rates for one in y])
    return _between_percentiles(value, drawn, confidence)


def _wins(mine: np.ndarray, other: np.ndarray) -> np.ndarray:
    """1 where mine is larger, 1/2 where both are equal: (N,), (M,) -> (N, M)."""
    return np.sign(mine[:, None] - other[None, :]) / 2.0 + 0.5


def _resampled(task: Seeds, resamples: int, generator: np.random.Generator) -> np.ndarray:
    """(resamples, N) rates."""
    count = len(task.successes)
    seeds = generator.integers(count, size=(resamples, count))
    episodes = np.array(task.episodes)[seeds]
    return generator.binomial(episodes, task.rates[seeds]) / episodes


def _between_percentiles(value: float, drawn: np.ndarray, confidence: float) -> Interval:
    tail = (1.0 - confidence) / 2.0
    low, high = np.quantile(drawn, (tail, 1.0 - tail))
    return Interval(value, float(low), float(high))
