"""A Gymnasium environment as the simulation of an arm that is known by its datasets.

Policies see it as they see any of this project's: named observations (D,), actions in [-1, 1].

    environment's observation -> columns of the dataset -> the numbers that models see
    environment's action      <- the dataset's action   <- [-1, 1]
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from lfr.data.own_columns import OwnColumns, own_columns
from lfr.data.resample import frames_of
from lfr.environments.entries import column_of, succeeded
from lfr.environments.process import EnvironmentFailure, EnvironmentProcess
from lfr.errors import LfrError
from lfr.external import EnvironmentParams, ExternalArm
from lfr.sim.steps import Steps
from lfr.spaces import space

Array = NDArray[np.float64]

CAMERA = "render"  # name of the pictures that an environment draws
FAILURES = 5  # in a row that are one too many
BEYOND = 1e-3  # of a bound, in shares of its range: bounds that were copied with four digits


@dataclass(frozen=True)
class ExternalTarget:
    """What an `ExternalSimulation` is made of, so that any process may make one.

    Attributes:
        robot, task: the arm, and what it does.
        params: of the environment.
        columns: of the arm's datasets.
        code: SHA-256 of the file that the environment's class stands in: another one is another
            environment.
    """

    robot: str
    task: str
    params: EnvironmentParams
    columns: OwnColumns
    code: str = ""

    def simulation(self) -> ExternalSimulation:
        return ExternalSimulation(self.robot, self.task, self.params, self.columns)


def external_target(
    robot: str, arm: ExternalArm | None, task: str, others: Sequence[str], names: Sequence[str]
) -> ExternalTarget | None:
    """Where an arm can do a task; None where ``arm`` names no environment for it, or is None.

    It is tried for a step, so that what does not fit is told before anything is learned.

    Raises:
        DataError: as `lfr.data.own_columns.own_columns`, whose arguments these are.
        LfrError: as `ExternalSimulation`.
    """
    if arm is None or task not in arm.environments:
        return None
    columns = own_columns(robot, arm, task, others, names)
    found = ExternalTarget(robot, task, arm.environments[task], columns)
    tried = found.simulation()
    tried.reset(0)
    tried.step(np.zeros((1, len(columns.selection.space.names))))
    tried.close()
    return replace(found, code=tried.code)


class ExternalSimulation:
    """One arm in one environment; an `lfr.transfer.environment.Resumable`.

    Its state is the episode's seed and the actions so far: Gymnasium knows of no other that every
    environment has. Going back to it carries these out again from the start.

    Where an arm is resampled, an action is carried out for as many steps of the environment as it
    lasts (`lfr.data.resample`); its reward is their sum.

    An episode that the environment ends without success goes on in its last observation up to the
    horizon, without reward. One in which it raises, or its process ends, is over, and the traceback
    is logged; that at once, or in several episodes in a row, is a fault.

    Args:
        columns: of the arm's datasets, which the environment's observation stands for.

    Attributes:
        robot, task: the arm, and what it does.
        layout: the names of what is observed.
        actions: what its actions in [-1, 1] stand for.
        horizon: control steps of an episode.
        rate: control steps per second.

    Raises:
        LfrError: it cannot be made, it has no such observation or another action, or it does not
            say how long an episode is.
    """

    def __init__(
        self, robot: str, task: str, params: EnvironmentParams, columns: OwnColumns
    ) -> None:
        self.robot, self.task, self._params, self._columns = robot, task, params, columns
        self.name = f"{robot}, {task}"  # for messages
        self.actions, self.rate = columns.selection.space, columns.fps / columns.ratio
        self.layout = space(columns.selection.observation_names)
        self._environment, self._closed = self._made(), False
        self.horizon = int((params.horizon or self._own_horizon()) / columns.ratio)
        self._box = self._checked_action()
        self._seed, self._done, self._over = 0, list[Array](), False
        self._failed, self._broken = 0, False  # episodes in a row that it ended by raising
        self._last = np.zeros(self.layout.size)

    def reset(self, seed: int) -> Array:
        """Begin the episode of a seed; the observation (D,).

        Raises:
            LfrError: it observes something else than its description says, or cannot be reset.
        """
        if self._closed:
            self._environment, self._closed = self._made(), False
        self._failed = self._failed if self._broken else 0
        self._seed, self._done, self._over, self._broken = seed, [], False, False
        try:
            observed = self._environment.reset(seed)
        except EnvironmentFailure as error:
            raise self._fault("cannot be reset", error) from error
        self._last = self._seen(observed)
        return self._last

    def step(self, actions: Array, stop_on_success: bool = False) -> Steps:
        """Carry out actions (n, A) in [-1, 1], one a control step.

        Raises:
            LfrError: it never says whether the task has succeeded, or does nothing but raise.
        """
        observations, rewards, successes = [], [], []
        for action in np.asarray(actions, np.float64):
            lasts = frames_of(len(self._done), self._columns.ratio)
            self._done.append(action)
            try:
                each = [self._stepped(action) for _ in range(lasts)]
                reward, success = sum(one for one, _ in each), any(one for _, one in each)
            except EnvironmentFailure as error:
                self._failed, self._broken = self._failed + 1, True
                if len(self._done) == 1 or self._failed == FAILURES:
                    raise self._fault("cannot go on", error) from error
                _log(self.name, error)
                self.close()
                return self._steps(observations, rewards, successes, failed=True)
            observations.append(self._last)
            rewards.append(reward)
            successes.append(success)
            if success and stop_on_success:
                break
        return self._steps(observations, rewards, successes)

    def state(self) -> Array:
        """The seed, the last observation and the actions of the episode so far, (1 + D + T A,)."""
        return np.concatenate([[float(self._seed)], self._last, *self._done])

    def set_state(self, state: Array) -> None:
        """Go on from where a `state` was taken; warns where the environment does not come back."""
        seed, seen, done = np.split(state, [1, 1 + self.layout.size])
        self.reset(int(seed[0]))
        if len(done):
            self.step(done.reshape(-1, len(self._columns.selection.space.names)))
        if not np.allclose(self._last, seen, rtol=0.0, atol=1e-6):
            logging.warning(
                "%s: the environment does not repeat itself from a seed; an episode goes on from "
                "another state than it was left in", self.name,
            )  # fmt: skip

    def picture(self) -> NDArray[np.uint8] | None:
        """What it looks like, (H, W, 3), where the environment draws."""
        return self._environment.render() if self._environment.about.draws else None

    @property
    def code(self) -> str:
        """SHA-256 of the file that the environment's class stands in; "" where there is none."""
        return self._environment.about.code

    def close(self) -> None:
        """End the environment's process; the next episode starts another."""
        self._environment.close()
        self._closed = True

    def _fault(self, what: str, error: EnvironmentFailure) -> LfrError:
        _log(self.name, error)
        return LfrError(f"{self.name}: the environment {what}: {error}")

    def _stepped(self, action: Array) -> tuple[float, bool]:
        if self._over:
            return 0.0, False
        observed, reward, self._over, info = self._environment.step(self._physical(action))
        self._last = self._seen(observed)
        return reward, succeeded(reward, info, self._params, self.name)

    def _steps(
        self,
        observations: list[Array],
        rewards: list[float],
        successes: list[bool],
        failed: bool = False,
    ) -> Steps:
        seen = np.array(observations).reshape(-1, self.layout.size)
        return Steps(seen, np.array(rewards), np.array(successes, bool), failed)

    def _physical(self, action: Array) -> NDArray[Any]:
        """As the environment's Box has it: rounding to float32 may have led beyond a bound."""
        selection, box = self._columns.selection, self._box
        physical = np.empty(len(action), np.float32)
        taken = selection.space.physical(action.astype(np.float32))
        physical[list(selection.action.places)] = taken
        return np.clip(physical, box.low, box.high).astype(box.dtype)

    def _seen(self, observed: Any) -> Array:
        def column(name: str) -> Array:
            values = column_of(observed, name, self._params, self.name)
            if len(values) != (size := self._columns.size_of(name)):
                raise LfrError(
                    f"{self.name}: {name} has {len(values)} numbers in the environment, "
                    f"expected {size} as in the dataset"
                )
            return values

        try:
            parts = [part.values(column) for part in self._columns.selection.observation]
        except ValueError as error:
            raise LfrError(f"{self.name}: {error}") from None
        return np.concatenate(parts)

    def _made(self) -> EnvironmentProcess:
        return made(self._params, self.name)

    def _own_horizon(self) -> int:
        horizon = self._environment.about.horizon
        if horizon is None:
            raise LfrError(f"{self.name}: the environment does not end by itself; say 'horizon'")
        return horizon

    def _checked_action(self) -> gymnasium.spaces.Box:
        """The environment's action, which the recorded ones are, and within its bounds."""
        selection, taken = self._columns.selection, self._environment.about.action_space
        size = len(selection.action.places)
        if not isinstance(taken, gymnasium.spaces.Box) or taken.shape != (size,):
            raise LfrError(f"{self.name}: the environment's action is {taken}, expected a Box of "
                           f"shape ({size},) as the dataset's")  # fmt: skip
        for name, place, low, high in zip(
            selection.space.names, selection.action.places, selection.space.low,
            selection.space.high, strict=True,
        ):  # fmt: skip
            least, most = float(taken.low[place]), float(taken.high[place])
            low, high = sorted((low, high))
            if low < least - BEYOND * (high - low) or high > most + BEYOND * (high - low):
                raise LfrError(
                    f"{self.name}: the action's {name} goes from {low:g} to {high:g}, the "
                    f"environment's from {least:g} to {most:g}"
                )
        return taken


def made(params: EnvironmentParams, name: str) -> EnvironmentProcess:
    """An environment, in a process of its own.

    Args:
        name: of the arm and task, for the message.

    Raises:
        LfrError: it cannot be made.
    """
    try:
        return EnvironmentProcess(params.id, params.kwargs)
    except EnvironmentFailure as error:  # an import, a name, an argument: whatever is wrong with it
        raise LfrError(f"{name}: no environment {params.id!r}: {error}") from error


def _log(name: str, error: EnvironmentFailure) -> None:
    logging.error("%s: the environment has failed: %s\n%s", name, error, error.trace)
