"""A policy's episode as it happens, with what it thought at every skill, for `lfr.view.policy`."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lfr.data.episode import (
    ACTION,
    DONE,
    ENVIRONMENT_STATE,
    FPS,
    JOINT_POSITION,
    REWARD,
    STATE,
    SUCCESS,
    Episode,
    EpisodeInfo,
)
from lfr.view.trace import SkillTrace

if TYPE_CHECKING:
    from torch import Tensor

    from lfr.sim.simulation import Simulation
    from lfr.transfer.actor import SkillActor

AFTER_SUCCESS = 10
"""Control steps shown after the first success: half a second, so that it can be seen."""


def roll_out_policy(
    actor: SkillActor, simulation: Simulation, seed: int
) -> tuple[Episode, SkillTrace]:
    """One episode of the policy's mean from the start of `seed`.

    It ends at the horizon, at divergence, or shortly after the first success. Nothing random is
    drawn, so a learning run that is looked at stays bit for bit the run that is not.
    """
    from lfr.transfer.actor import as_tensor

    frames = _Frames(simulation)
    observation = simulation.reset(seed)
    starts: list[int] = []
    rows: list[list[NDArray[np.floating]]] = []
    while not frames.over:
        batch = as_tensor(observation[None])
        choice = actor.choose(batch)
        gaussians = (actor.prior.pi(batch), actor.prior(batch))  # p_a and phi(p_a)
        flat = [*choice, *(part for pair in gaussians for part in pair)]
        starts.append(len(frames.rewards))
        rows.append([_array(part) for part in flat])
        for action in actor.decode(choice.z)[0]:
            observation = frames.step(observation, action)
            if frames.over:
                break
    columns = [np.stack(column) for column in zip(*rows, strict=True)]
    return frames.episode(seed), SkillTrace(np.array(starts), *columns)


class _Frames:
    """The frames of an episode under way."""

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation
        self.observations: list[NDArray[np.float64]] = []
        self.joints: list[NDArray[np.float64]] = []
        self.actions: list[NDArray[np.float64]] = []
        self.states: list[NDArray[np.float64]] = []
        self.rewards: list[float] = []
        self.successes: list[bool] = []
        self.diverged = False

    @property
    def over(self) -> bool:
        done = len(self.rewards) >= self.simulation.horizon or self.diverged
        return done or sum(self.successes) > AFTER_SUCCESS

    def step(
        self, observation: NDArray[np.float64], action: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        self.observations.append(observation)
        self.joints.append(self.simulation.joint_position())
        self.states.append(self.simulation.state())
        self.actions.append(action)
        steps = self.simulation.step(action[None])
        self.rewards.append(float(steps.rewards[0]))
        self.successes.append(bool(steps.successes[0]))
        self.diverged = steps.diverged
        return steps.observations[0].copy()

    def episode(self, seed: int) -> Episode:
        simulation = self.simulation
        info = EpisodeInfo.of(simulation.embodiment, simulation.task, seed)
        observations = np.array(self.observations)
        columns: dict[str, Any] = {
            STATE: observations[:, : ROBOT_STATE.size],
            ENVIRONMENT_STATE: observations[:, ROBOT_STATE.size :],
            JOINT_POSITION: np.array(self.joints),
            ACTION: np.array(self.actions),
            REWARD: np.array(self.rewards),
            SUCCESS: np.array(self.successes),
            DONE: np.arange(len(self.rewards)) == len(self.rewards) - 1,
        }
        schema = info.features
        return Episode(
            robot=info.robot,
            task=info.task,
            seed=seed,
            success=any(self.successes),
            features={key: column.astype(schema[key].dtype) for key, column in columns.items()},
            simulator_state=np.array([*self.states, simulation.state()]),
            metadata={
                "instruction": info.instruction,
                "controller": info.controller,
                "fps": FPS,
                "features": {key: asdict(feature) for key, feature in schema.items()},
            },
        )


def _array(row: Tensor) -> NDArray[np.floating]:
    return row[0].detach().numpy().astype(np.float64)
