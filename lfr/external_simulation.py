"""A Gymnasium environment as the simulation of an arm that is known by its datasets.

Policies see it as they see any of this project's: named observations (D,), actions in [-1, 1].

    environment's observation -> columns of the dataset -> the numbers that models see
    environment's action      <- the dataset's action   <- [-1, 1]
"""

from __future__ import annotations

import contextlib
import inspect
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from lfr.artifacts import file_hash
from lfr.data.own_columns import OwnColumns, own_columns
from lfr.errors import LfrError
from lfr.external import EnvironmentParams, ExternalArm
from lfr.sim.steps import Steps
from lfr.spaces import space

Array = NDArray[np.float64]

FAILURES = 5  # in a row that are one too many
BEYOND = 1e-3  # of a bound, in shares of its range: bounds that were copied with four digits


@dataclass(frozen=True)
class ExternalTarget:
    """What an `ExternalSimulation` is made of, so that any process may make one.

    Attributes:
        name: of the arm and task, for messages.
        params: of the environment.
        columns: of the arm's datasets.
        code: SHA-256 of the file that the environment's class stands in: another one is another
            environment.
    """

    name: str
    params: EnvironmentParams
    columns: OwnColumns
    code: str = ""

    def simulation(self) -> ExternalSimulation:
        return ExternalSimulation(self.name, self.params, self.columns)


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
    found = ExternalTarget(f"{robot}, {task}", arm.environments[task], columns)
    tried = found.simulation()
    tried.reset(0)
    tried.step(np.zeros((1, len(columns.selection.space.names))))
    code = tried.code()
    tried.close()
    return replace(found, code=code)


class ExternalSimulation:
    """One arm in one environment; an `lfr.transfer.environment.Resumable`.

    Its state is the episode's seed and the actions so far: Gymnasium knows of no other that every
    environment has. Going back to it carries these out again from the start.

    An episode that the environment ends without success goes on in its last observation up to the
    horizon, without reward. One in which it raises is over, and the traceback is logged; raising
    at once, or in several episodes in a row, is a fault.

    Args:
        name: of the arm and task, for messages.
        columns: of the arm's datasets, which the environment's observation stands for.

    Attributes:
        layout: the names of what is observed.
        horizon: control steps of an episode.

    Raises:
        LfrError: it cannot be made, it has no such observation or another action, or it does not
            say how long an episode is.
    """

    def __init__(self, name: str, params: EnvironmentParams, columns: OwnColumns) -> None:
        self.name, self._params, self._columns = name, params, columns
        self.layout = space(columns.selection.observation_names)
        self._environment = self._made()
        self.horizon = params.horizon or self._own_horizon()
        self._box = self._checked_action()
        self._seed, self._done, self._over = 0, list[Array](), False
        self._failed, self._broken = 0, False  # episodes in a row that it ended by raising
        self._last = np.zeros(self.layout.size)

    def reset(self, seed: int) -> Array:
        """Begin the episode of a seed; the observation (D,).

        Raises:
            LfrError: it observes something else than its description says, or cannot be reset.
        """
        if self._environment is None:
            self._environment = self._made()
        self._failed = self._failed if self._broken else 0
        self._seed, self._done, self._over, self._broken = seed, [], False, False
        try:
            observed, _ = self._environment.reset(seed=seed)
        except Exception as error:
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
            self._done.append(action)
            try:
                reward, success = self._stepped(action)
            except LfrError:
                raise
            except Exception as error:  # whatever an environment of somebody's raises
                self._failed, self._broken = self._failed + 1, True
                if len(self._done) == 1 or self._failed == FAILURES:
                    raise self._fault("cannot go on", error) from error
                logging.exception("%s: the environment has failed; so has the episode", self.name)
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

    def code(self) -> str:
        """SHA-256 of the file that the environment's class stands in; "" where there is none."""
        assert self._environment is not None
        file = inspect.getsourcefile(type(self._environment.unwrapped))
        return file_hash(Path(file)) if file else ""

    def close(self) -> None:
        """Give it up; the next episode makes another one."""
        environment, self._environment = self._environment, None
        if environment is not None:
            with contextlib.suppress(Exception):  # of one that has failed
                environment.close()

    def _fault(self, what: str, error: Exception) -> LfrError:
        said = " ".join(str(error).split())
        logging.exception("%s: the environment has failed", self.name)
        return LfrError(f"{self.name}: the environment {what}: {type(error).__name__}: {said}")

    def _stepped(self, action: Array) -> tuple[float, bool]:
        if self._over:
            return 0.0, False
        assert self._environment is not None
        observed, reward, terminated, truncated, info = self._environment.step(
            self._physical(action)
        )
        self._last, self._over = self._seen(observed), bool(terminated or truncated)
        return float(reward), self._success(float(reward), info)

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
        taken = []
        for part in self._columns.selection.observation:
            values = self._column(observed, part.column)
            if len(values) != (size := self._columns.size_of(part.column)):
                raise LfrError(
                    f"{self.name}: {part.column} has {len(values)} numbers in the environment, "
                    f"expected {size} as in the dataset"
                )
            taken.append(values[list(part.places)] / part.unit)
        return np.concatenate(taken)

    def _column(self, observed: Any, column: str) -> Array:
        entry = self._params.observation.get(column)
        if entry is None and not self._params.observation and not isinstance(observed, Mapping):
            return np.asarray(observed, np.float64).ravel()
        there, way = observed, entry.split(".") if entry is not None else []
        for key in way:
            if not isinstance(there, Mapping) or key not in there:
                break
            there = there[key]
        else:
            if way and not isinstance(there, Mapping):
                return np.asarray(there, np.float64).ravel()
        raise LfrError(
            f"{self.name}: {column} is {entry!r} of the environment's observation, which has "
            f"{', '.join(_entries(observed)) or 'no entries'}; say which under 'observation'"
        )

    def _success(self, reward: float, info: Mapping[str, Any]) -> bool:
        if self._params.success_reward is not None:
            return reward >= self._params.success_reward
        if self._params.success not in info:
            raise LfrError(
                f"{self.name}: the environment never says {self._params.success!r}; its info has "
                f"{', '.join(info) or 'nothing'}; name one under 'success', or a 'success_reward'"
            )
        return bool(np.asarray(info[self._params.success]).item())

    def _made(self) -> gymnasium.Env[Any, Any]:
        try:
            return gymnasium.make(self._params.id, **self._params.kwargs)
        except Exception as error:  # an import, a name, an argument: whatever is wrong with it
            said = " ".join(str(error).split())
            raise LfrError(
                f"{self.name}: no environment {self._params.id!r}: {type(error).__name__}: {said}"
            ) from error

    def _own_horizon(self) -> int:
        assert self._environment is not None
        spec = self._environment.spec
        if spec is None or spec.max_episode_steps is None:
            raise LfrError(f"{self.name}: the environment does not end by itself; say 'horizon'")
        return spec.max_episode_steps

    def _checked_action(self) -> gymnasium.spaces.Box:
        """The environment's action, which the recorded ones are, and within its bounds."""
        assert self._environment is not None
        selection, taken = self._columns.selection, self._environment.action_space
        size = len(selection.action.places)
        if not isinstance(taken, gymnasium.spaces.Box) or taken.shape != (size,):
            raise LfrError(f"{self.name}: the environment's action is {taken}, expected a Box of "
                           f"shape ({size},) as the dataset's")  # fmt: skip
        for name, place, low, high in zip(
            selection.space.names, selection.action.places, selection.space.low,
            selection.space.high, strict=True,
        ):  # fmt: skip
            least, most = float(taken.low[place]), float(taken.high[place])
            if low < least - BEYOND * (high - low) or high > most + BEYOND * (high - low):
                raise LfrError(
                    f"{self.name}: the action's {name} goes from {low:g} to {high:g}, the "
                    f"environment's from {least:g} to {most:g}"
                )
        return taken


def _entries(observed: Any, before: str = "") -> list[str]:
    """The dotted names of all that an observation holds."""
    if not isinstance(observed, Mapping):
        return [before] if before else []
    found = []
    for key, value in observed.items():
        found += _entries(value, f"{before}.{key}" if before else str(key))
    return found
