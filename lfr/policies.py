"""A policy, how a job names one, and the episodes that it acts in.

    observation (D,) ─► act ─► actions (n, A), one a control step ─► observation (D,) ─► act ...

A policy by skills answers with the n control steps of its next skill, any other with one. Each room
that can load one has its `PolicySource`: `lfr.skills.skill_policy`, `lfr.mapping.mapped_policy`,
`lfr.mapping.retarget`, `lfr.transfer.model`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from lfr.artifacts import fingerprint
from lfr.sim.steps import Steps

Array = NDArray[np.float64]


class Policy(Protocol):
    """Acts by what it observes, and may remember within an episode."""

    def reset(self, seed: int, /) -> None:
        """An episode begins.

        All that the policy draws in it follows from ``seed``: an episode is the same whichever ones
        came before it, so that a trial may be cut into shards.
        """
        ...

    def act(self, observation: Array, /) -> Array:
        """The next actions (n, A) in [-1, 1] for an observation (D,)."""
        ...


@runtime_checkable
class Attached(Protocol):
    """A policy that acts by more than what is observed: it is shown the simulation that it acts in.

    So is retargeting, which must know the arm's joints.
    """

    def attach(self, simulation: Any, /) -> None:
        """Before each episode, and before `Policy.reset`."""
        ...


class PolicySource(Protocol):
    """A frozen dataclass of the folders of a policy; it names the policy in a job."""

    def load(self, robot: str, /) -> Policy:
        """The policy, to act on the embodiment called ``robot``.

        Raises:
            DataError: a folder holds no such model, or a damaged one, or the policy's actions are
                not this embodiment's.
        """
        ...


@dataclass(frozen=True)
class Pinned:
    """A policy named by the content of its folders too: another one there is another policy."""

    source: PolicySource
    content: str  # fingerprint

    @classmethod
    def of(cls, source: PolicySource) -> Pinned:
        """Raises DataError where a folder is missing."""
        folders = (Path(folder) for folder in vars(source).values() if folder)
        return cls(source, fingerprint(*folders))

    def load(self, robot: str) -> Policy:
        return self.source.load(robot)


class Simulated(Protocol):
    """One arm in one task (`lfr.sim.simulation.Simulation`, or its stock counterpart)."""

    horizon: int  # control steps of an episode

    def reset(self, seed: int, /) -> Array: ...
    def step(self, actions: Array, /, stop_on_success: bool = False) -> Steps: ...


@dataclass(frozen=True)
class Outcome:
    """How an episode went: success reached at any step within the horizon, and when."""

    seed: int
    success: bool
    steps: int  # until success, else of the whole episode


def roll_out(policy: Policy, simulation: Simulated, seeds: Iterable[int]) -> list[Outcome]:
    """One episode per seed, until success or the task's horizon."""
    return [run_episode(policy, simulation, seed) for seed in seeds]


def run_episode(policy: Policy, simulation: Simulated, seed: int, linger: int = 0) -> Outcome:
    """An episode from the start of ``seed``: until success, divergence or the task's horizon.

    Whoever wants to see every step hands in a policy or a simulation that notes what goes through
    it (`lfr.view.rollout`).

    Args:
        linger: control steps that it goes on after success.
    """
    if isinstance(policy, Attached):
        policy.attach(simulation)
    policy.reset(seed)
    observation, done, end = simulation.reset(seed), 0, simulation.horizon
    reached: int | None = None
    ahead: Array | None = None  # what success has interrupted
    while done < end:
        actions = policy.act(observation) if ahead is None else ahead
        steps = simulation.step(actions[: end - done], stop_on_success=reached is None)
        done += len(steps)
        if steps.diverged:
            break
        ahead = actions[len(steps) :] if len(steps) < len(actions) else None
        if reached is None and steps.successes.any():
            reached, end = done, min(done + linger, end)
        observation = steps.observations[-1]
    return Outcome(seed, reached is not None, done if reached is None else reached)
