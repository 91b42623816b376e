"""The starts of a learning run: each run, by its seed, has a share of the learning seeds."""

from __future__ import annotations

from lfr.seeds import episode_seed

# Evaluation starts come first in a run's share, the starts that it learns from after them.
SEEDS_PER_RUN = 40_000
EVALUATION_SEEDS = 1_000


def evaluation_starts(run: int, count: int) -> list[int]:
    """Episode seeds of the run's curve, the same ones at every point; at most EVALUATION_SEEDS."""
    return [
        episode_seed("learning", run * SEEDS_PER_RUN + i)
        for i in range(min(count, EVALUATION_SEEDS))
    ]


def learning_start(run: int, episode: int) -> int:
    """Episode seed of the run's ``episode``-th learning episode."""
    offset = EVALUATION_SEEDS + episode % (SEEDS_PER_RUN - EVALUATION_SEEDS)
    return episode_seed("learning", run * SEEDS_PER_RUN + offset)
