"""A policy's episode as it happens, with what it thought at every skill."""

from __future__ import annotations

from collections.abc import Sequence
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
from lfr.policies import run_episode
from lfr.sim.steps import Steps
from lfr.spaces import ROBOT_STATE
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

    It ends at the horizon, at divergence, or shortly after the first success.
    """
    policy, recorded = _TracedPolicy(actor), _RecordedSimulation(simulation)
    run_episode(policy, recorded, seed, linger=AFTER_SUCCESS)
    return recorded.episode(seed), policy.trace()


class _TracedPolicy:
    """The policy, with what it thought at every skill."""

    def __init__(self, actor: SkillActor) -> None:
        self.actor = actor

    def reset(self, seed: int) -> None:
        self.actor.reset(seed)
        self.starts: list[int] = []
        self.rows: list[list[NDArray[np.floating]]] = []
        self.next = 0  # control step at which the next skill begins

    def act(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        from lfr.transfer.actor import as_tensor

        batch = as_tensor(observation[None])
        choice = self.actor.choose(batch)
        gaussians = (self.actor.prior.pi(batch), self.actor.prior(batch))  # p_a and phi(p_a)
        self.rows.append([_array(p) for p in (*choice, *(p for pair in gaussians for p in pair))])
        actions = self.actor.decode(choice.z, batch)[0]
        self.starts.append(self.next)
        self.next += len(actions)
        return actions

    def trace(self) -> SkillTrace:
        columns = [np.stack(column) for column in zip(*self.rows, strict=True)]
        return SkillTrace(np.array(self.starts), *columns)


class _RecordedSimulation:
    """The simulation, with the frames of the episode under way."""

    def __init__(self, simulation: Simulation) -> None:
        self.simulation, self.horizon = simulation, simulation.horizon

    def reset(self, seed: int) -> NDArray[np.float64]:
        self.observations = [self.simulation.reset(seed)]
        self.joints: list[NDArray[np.float64]] = []
        self.actions: list[NDArray[np.float64]] = []
        self.states: list[NDArray[np.float64]] = []
        self.done: list[Steps] = []
        return self.observations[0]

    def step(self, actions: NDArray[np.float64], stop_on_success: bool = False) -> Steps:
        """As the simulation's own, one control step at a time."""
        done: list[Steps] = []
        for action in actions:
            self.joints.append(self.simulation.joint_position())
            self.states.append(self.simulation.state())
            self.actions.append(action)
            done.append(steps := self.simulation.step(action[None]))
            self.observations.append(steps.observations[0])
            if steps.diverged or (stop_on_success and steps.successes[0]):
                break
        self.done += done
        return _together(done)

    def episode(self, seed: int) -> Episode:
        simulation = self.simulation
        info = EpisodeInfo.of(simulation.embodiment, simulation.task, seed)
        steps = _together(self.done)
        observations = np.array(self.observations[:-1])
        columns: dict[str, Any] = {
            STATE: observations[:, : ROBOT_STATE.size],
            ENVIRONMENT_STATE: observations[:, ROBOT_STATE.size :],
            JOINT_POSITION: np.array(self.joints),
            ACTION: np.array(self.actions),
            REWARD: steps.rewards,
            SUCCESS: steps.successes,
            DONE: np.arange(len(steps)) == len(steps) - 1,
        }
        schema = info.features
        return Episode(
            robot=info.robot,
            task=info.task,
            seed=seed,
            success=bool(steps.successes.any()),
            features={key: column.astype(schema[key].dtype) for key, column in columns.items()},
            simulator_state=np.array([*self.states, simulation.state()]),
            metadata={
                "instruction": info.instruction,
                "controller": info.controller,
                "fps": FPS,
                "features": {key: asdict(feature) for key, feature in schema.items()},
            },
        )


def _together(steps: Sequence[Steps]) -> Steps:
    return Steps(
        np.concatenate([one.observations for one in steps]),
        np.concatenate([one.rewards for one in steps]),
        np.concatenate([one.successes for one in steps]),
        steps[-1].diverged,
    )


def _array(row: Tensor) -> NDArray[np.floating]:
    return row[0].detach().numpy().astype(np.float64)
