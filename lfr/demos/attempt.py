"""One attempt of the expert at a task, from a drifted start to success and a little beyond."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from lfr.demos.expert import Expert, ExpertParams

if TYPE_CHECKING:
    from lfr.sim.simulation import Simulation


@dataclass(frozen=True)
class DriftParams:
    """Unrecorded motion before a demonstration, so that demonstrations start all over the place.

    Stock resets vary an arm's start by about 1 cm. A prior trained there is lost where another
    arm starts: Sawyer's hand rests 16 cm to the side of Panda's.
    """

    steps: int = 96  # at most; the number is drawn uniformly for each attempt
    speed: float = 0.9  # bound on each component of the drift's direction, as a hand motion
    turn: float = 0.3  # bound on the drift's rotation about each axis, as a hand motion


@dataclass(frozen=True)
class AttemptParams:
    """How a demonstration is made."""

    expert: ExpertParams = field(default_factory=ExpertParams)
    drift: DriftParams = field(default_factory=DriftParams)
    linger: int = 10  # steps recorded after the first success, so that its windows are whole


@dataclass(frozen=True)
class Moment:
    """One control step: what was seen, what should be done, what came of it.

    Attributes:
        observation: (D,), before the action.
        action: (A,), the expert's clean action, which a learner should imitate.
        executed: (A,), the noisy action that the arm was given, which a replay needs.
        reward: robosuite's dense reward after it.
        success: robosuite's success check after it.
        joint_position: (N,) rad, before the action.
        simulator_state: (S,), before the action.
    """

    observation: np.ndarray
    action: np.ndarray
    executed: np.ndarray
    reward: float
    success: bool
    joint_position: np.ndarray
    simulator_state: np.ndarray


def attempt(simulation: Simulation, params: AttemptParams, seed: int) -> Iterator[Moment]:
    """Yield the moments of one attempt; the last ones show success if it was reached.

    It ends ``linger`` steps after the first success, at the task's horizon, or when the physics
    diverges. The same seed gives the same moments.
    """
    rng = np.random.default_rng([seed, 1])  # the placement has the seed's own stream
    observation = simulation.reset(seed)
    observation = _drift(simulation, observation, params.drift, rng)
    expert = Expert(simulation.task, simulation.layout, params.expert)
    controller, remaining = simulation.embodiment.controller, simulation.horizon
    while remaining > 0:
        joints, state = simulation.joint_position(), simulation.state()
        wanted = expert.clean(observation)
        done = expert.execute(wanted, rng)
        there = simulation.configuration()
        clean, executed = (controller.label(motion, there) for motion in (wanted, done))
        steps = simulation.step(executed[None])
        if steps.diverged:
            return
        success = bool(steps.successes[-1])
        reward = float(steps.rewards[-1])
        yield Moment(observation, clean, executed, reward, success, joints, state)
        observation = steps.observations[-1]
        remaining -= 1
        if success:
            remaining = min(remaining, params.linger)


def _drift(
    simulation: Simulation, observation: np.ndarray, drift: DriftParams, rng: np.random.Generator
) -> np.ndarray:
    """Let the hand drift in one direction, seldom toward the table; the new observation."""
    count = int(rng.integers(drift.steps + 1))
    if count == 0:
        return observation
    move = drift.speed * rng.uniform(-1.0, 1.0, 3)
    move[2] = drift.speed * rng.uniform(-0.4, 1.0)
    turn = drift.turn * rng.uniform(-1.0, 1.0, 3)
    gripper = rng.choice([-1.0, 1.0])  # an empty hand that is closed must be opened again
    motion, controller = np.concatenate([move, turn, [gripper]]), simulation.embodiment.controller
    for _ in range(count):
        action = controller.label(motion, simulation.configuration())
        observation = simulation.step(action[None]).observations[-1]
    return observation
