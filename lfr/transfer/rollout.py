"""A cheap evaluation while learning: the mean policy from a fixed set of starts.

The learning run's own simulations step side by side here, on as many cores as there are, so that
one decode serves all of them; `lfr.policies.roll_out`, one episode after the other, would take
longer, and batches of one differ from larger ones in the last bits.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from lfr.policies import Array
from lfr.transfer.actor import SkillActor
from lfr.transfer.environment import Resumable, RewardRule, RunningEpisode


@dataclass(frozen=True)
class EpisodeOutcome:
    """How one evaluation episode went."""

    seed: int
    success: bool
    total_reward: float
    length: int


def evaluate(
    actor: SkillActor, simulations: Sequence[Resumable], seeds: Sequence[int], rule: RewardRule
) -> list[EpisodeOutcome]:
    """One episode per seed, in the order of the seeds, as many at once as there are simulations."""
    waiting = list(enumerate(seeds))[::-1]
    results: dict[int, EpisodeOutcome] = {}
    running: list[tuple[int, RunningEpisode]] = []
    idle, cores = list(simulations), len(os.sched_getaffinity(0))

    def execute(episode: RunningEpisode, skill: Array) -> bool:
        return episode.execute(skill, rule).over  # the simulation releases the GIL

    with ThreadPoolExecutor(min(len(simulations), cores)) as threads:
        while waiting or running:
            while waiting and idle:
                place, seed = waiting.pop()
                episode = RunningEpisode(idle.pop())
                episode.start(seed)
                running.append((place, episode))
            episodes = [episode for _, episode in running]
            actions = actor.act_all(np.stack([episode.observation for episode in episodes]))
            over = list(threads.map(execute, episodes, actions))
            for (place, episode), ended in zip(running, over, strict=True):
                if ended:
                    results[place] = EpisodeOutcome(
                        episode.seed, episode.success, episode.total, episode.length
                    )
                    idle.append(episode.simulation)
            running = [one for one, ended in zip(running, over, strict=True) if not ended]
    return [results[place] for place in range(len(seeds))]
