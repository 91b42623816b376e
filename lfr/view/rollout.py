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
    FEATURES,
    FPS,
    JOINT_POSITION,
    REWARD,
    STATE,
    SUCCESS,
    Episode,
    EpisodeInfo,
    Feature,
)
from lfr.data.messages import jpeg
from lfr.environments.simulation import CAMERA, ExternalSimulation
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
    actor: SkillActor, simulation: Simulation | ExternalSimulation, seed: int
) -> tuple[Episode, SkillTrace]:
    """One episode of the policy's mean from the start of `seed`.

    It ends at the horizon, at divergence, or shortly after the first success.
    """
    policy = _TracedPolicy(actor)
    if isinstance(simulation, ExternalSimulation):
        recorded = _RecordedEnvironment(simulation)
    else:
        recorded = _RecordedSimulation(simulation)
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


class _Recorded:
    """A simulation, with the frames of the episode under way."""

    def __init__(self, simulation: Simulation | ExternalSimulation) -> None:
        self.horizon, self._simulation = simulation.horizon, simulation

    def reset(self, seed: int) -> NDArray[np.float64]:
        self.observations = [self._simulation.reset(seed)]
        self.actions: list[NDArray[np.float64]] = []
        self.done: list[Steps] = []
        return self.observations[0]

    def step(self, actions: NDArray[np.float64], stop_on_success: bool = False) -> Steps:
        """As the simulation's own, one control step at a time."""
        done: list[Steps] = []
        for action in actions:
            self.note()
            self.actions.append(action)
            done.append(steps := self._simulation.step(action[None]))
            self.observations += list(steps.observations)
            if steps.diverged or (stop_on_success and steps.successes[0]):
                break
        self.done += done
        return _together(done)

    def note(self) -> None:
        """What else is recorded of the moment before an action."""

    def recorded(
        self,
        info: EpisodeInfo,
        columns: dict[str, Any],
        states: NDArray[np.float64],
        images: dict[str, list[bytes]],
        fps: float,
    ) -> Episode:
        """The episode, of columns before each action; what came of these is added."""
        steps, schema = _together(self.done), info.features
        count = len(steps)
        columns |= {
            REWARD: steps.rewards,
            SUCCESS: steps.successes,
            DONE: np.arange(count) == count - 1,
        }
        return Episode(
            robot=info.robot,
            task=info.task,
            seed=info.seed,
            success=bool(steps.successes.any()),
            features={
                key: column[:count].astype(schema[key].dtype) for key, column in columns.items()
            },
            simulator_state=states,
            images=images,
            metadata={
                "instruction": info.instruction,
                "controller": info.controller,
                "fps": fps,
                "features": {key: asdict(feature) for key, feature in schema.items()},
            },
        )


class _RecordedSimulation(_Recorded):
    """One of this project's own."""

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation)
        self.simulation = simulation

    def reset(self, seed: int) -> NDArray[np.float64]:
        self.joints: list[NDArray[np.float64]] = []
        self.states: list[NDArray[np.float64]] = []
        return super().reset(seed)

    def note(self) -> None:
        self.joints.append(self.simulation.joint_position())
        self.states.append(self.simulation.state())

    def episode(self, seed: int) -> Episode:
        observations = np.array(self.observations[: len(self.actions)])
        info = EpisodeInfo.of(self.simulation.embodiment, self.simulation.task, seed)
        columns = {
            STATE: observations[:, : ROBOT_STATE.size],
            ENVIRONMENT_STATE: observations[:, ROBOT_STATE.size :],
            JOINT_POSITION: np.array(self.joints),
            ACTION: np.array(self.actions),
        }
        states = np.array([*self.states, self.simulation.state()])
        return self.recorded(info, columns, states, {}, FPS)


class _RecordedEnvironment(_Recorded):
    """One of an arm that is known by its datasets: what models see, and actions in their units."""

    def __init__(self, simulation: ExternalSimulation) -> None:
        super().__init__(simulation)
        self.simulation = simulation

    def reset(self, seed: int) -> NDArray[np.float64]:
        self.pictures: list[bytes] = []
        return super().reset(seed)

    def note(self) -> None:
        if (picture := self.simulation.picture()) is not None:
            message: Any = jpeg(CAMERA, picture, 0)
            self.pictures.append(message.data)

    def episode(self, seed: int) -> Episode:
        simulation = self.simulation
        schema = {
            STATE: Feature(STATE, "float32", simulation.layout.names, "as models see it"),
            ACTION: Feature(ACTION, "float32", simulation.actions.names, "in the dataset's units"),
            **{one.key: one for one in FEATURES if one.key in (REWARD, SUCCESS, DONE)},
        }
        info = EpisodeInfo(simulation.robot, simulation.task, seed, simulation.task, schema)
        columns = {
            STATE: np.array(self.observations[: len(self.actions)]),
            ACTION: simulation.actions.physical(np.array(self.actions)),
        }
        nothing = np.zeros((len(self.actions) + 1, 0))
        images = {CAMERA: self.pictures} if self.pictures else {}
        return self.recorded(info, columns, nothing, images, simulation.rate)


def _together(steps: Sequence[Steps]) -> Steps:
    return Steps(
        np.concatenate([one.observations for one in steps]),
        np.concatenate([one.rewards for one in steps]),
        np.concatenate([one.successes for one in steps]),
        steps[-1].diverged,
    )


def _array(row: Tensor) -> NDArray[np.floating]:
    return row[0].detach().numpy().astype(np.float64)
