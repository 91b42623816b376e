"""Episodes of a policy in a simulation, judged by robosuite's own success check."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from lfr.sim.steps import Steps
from lfr.spaces import Space
from lfr.tasks import Task


class Policy(Protocol):
    """Anything that answers an observation (D,) with the actions (H, 7) of its next skill."""

    def act(self, observation: np.ndarray) -> np.ndarray: ...


class Judge(Protocol):
    """What an episode needs of `lfr.sim.simulation.Simulation` or of its stock counterpart."""

    task: Task
    layout: Space
    horizon: int

    def reset(self, seed: int) -> np.ndarray: ...
    def step(self, actions: np.ndarray, stop_on_success: bool = False) -> Steps: ...


@dataclass(frozen=True)
class Outcome:
    """How an episode went: success reached at any step within the horizon, and when."""

    seed: int
    success: bool
    steps: int


def roll_out(policy: Policy, simulation: Judge, seeds: Iterable[int]) -> list[Outcome]:
    """One episode per seed, until success or the task's horizon."""
    return [_episode(policy, simulation, seed) for seed in seeds]


def _episode(policy: Policy, simulation: Judge, seed: int) -> Outcome:
    observation, done = simulation.reset(seed), 0
    while done < simulation.horizon:
        actions = policy.act(observation)[: simulation.horizon - done]
        steps = simulation.step(actions, stop_on_success=True)
        done += len(steps)
        if steps.diverged:
            break
        if steps.successes.any():
            return Outcome(seed, True, done)
        observation = steps.observations[-1]
    return Outcome(seed, False, done)
