"""How far the messages of a dataset's frames are from the frames, topic by topic."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lfr.importing.bag.episodes import BagPlan
from lfr.importing.bag.mapping import BagMapping, Method


@dataclass(frozen=True)
class Lag:
    """Of one part: seconds between a frame and its message, over all frames of all episodes."""

    topic: str
    field: str
    method: Method
    median: float
    percentile_95: float
    longest: float

    def __str__(self) -> str:
        """One line of milliseconds."""
        name = f"{self.topic} {self.field}".strip()
        figures = (self.median, self.percentile_95, self.longest)
        median, percentile, longest = (f"{1e3 * figure:.1f}" for figure in figures)
        return (f"{name}: {self.method} message, lag median {median} ms, 95 % {percentile} ms, "
                f"longest {longest} ms")  # fmt: skip


def lags_of(plans: Sequence[BagPlan], mapping: BagMapping) -> tuple[Lag, ...]:
    """The lag of each part."""
    lags = []
    for part in mapping.parts:
        all_ = np.concatenate([plan.lags[part] for plan in plans if plan.episodes]) / 1e9
        median, percentile = np.quantile(all_, [0.5, 0.95]).tolist()
        lags.append(Lag(part.topic, part.field, part.method, median, percentile, float(all_.max())))
    return tuple(lags)
