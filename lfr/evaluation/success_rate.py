"""How sure a success rate is."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy.stats import norm


@dataclass(frozen=True)
class Success:
    """Successes out of episodes, with the Wilson interval of the rate.

    Attributes:
        rate: successes / episodes.
        low, high: bounds of the interval.
    """

    successes: int
    episodes: int
    rate: float
    low: float
    high: float


def success_of(successes: int, episodes: int, confidence: float = 0.95) -> Success:
    """A measured success rate with its Wilson score interval (Wilson 1927).

    Unlike the normal interval it stays within [0, 1] and does not shrink to a point at 0 or 1.

    Raises:
        ValueError: no episode, or more successes than episodes.
    """
    if not 0 <= successes <= episodes or episodes == 0:
        raise ValueError(f"{successes} successes of {episodes} episodes")
    low, high = wilson_interval(successes, episodes, confidence)
    return Success(successes, episodes, successes / episodes, low, high)


def wilson_interval(successes: int, episodes: int, confidence: float = 0.95) -> tuple[float, float]:
    """Bounds of a binomial proportion, by Wilson's score test without continuity correction."""
    z = float(norm.ppf(0.5 + confidence / 2.0))
    n, p = float(episodes), successes / episodes
    centre = (p + z * z / (2.0 * n)) / (1.0 + z * z / n)
    half = z * math.sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n)) / (1.0 + z * z / n)
    # Exactly 0 and 1 at the ends, which rounding misses by some 1e-17.
    low = 0.0 if successes == 0 else max(centre - half, 0.0)
    high = 1.0 if successes == episodes else min(centre + half, 1.0)
    return low, high
