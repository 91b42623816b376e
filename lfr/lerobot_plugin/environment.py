"""One of this project's environments as LeRobot's scripts expect them."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from gymnasium.wrappers import TimeLimit
from lerobot.envs.utils import FreezeAfterEpisodeEnd
from numpy.typing import NDArray

from lfr.seeds import PER_USE, Use, episode_seed
from lfr.sim.camera_params import CameraParams, check_names
from lfr.sim.environment import Environment, Reward, environment_id
from lfr.spaces import ROBOT_STATE

if TYPE_CHECKING:
    from lfr.sim.camera import Camera

STATE, ENVIRONMENT_STATE = slice(ROBOT_STATE.size), slice(ROBOT_STATE.size, None)


class LeRobotEnvironment(gymnasium.Wrapper):
    """An arm in a task, observed by LeRobot's names, over at success as our own evaluation has it.

    `reset(seed=k)` starts the k-th episode of a use (`lfr.seeds`): with `held-out`, the k-th start
    that our evaluation judges policies on. The observation is a dictionary of `agent_pos` (11,)
    and `environment_state` (E,), float64, and with `cameras` of `pixels` with each one's
    (height, width, 3) uint8; LeRobot calls them `observation.state`,
    `observation.environment_state` and `observation.images.<camera>`. An episode ends
    ("terminated") with `info["is_success"]`, or when the physics diverges.

    Args:
        robot, task, reward: as for `lfr.sim.environment.Environment`.
        seeds: whose starts `reset` gives.
        cameras: whose pictures are observed too.
    """

    def __init__(
        self,
        robot: str,
        task: str,
        reward: Reward = "dense",
        seeds: Use = "held-out",
        cameras: Sequence[CameraParams] = (),
    ) -> None:
        check_names(cameras)
        environment = Environment(robot, task, reward, render_mode="rgb_array")
        super().__init__(environment)
        self._seeds: Use = seeds
        self._simulation = environment.simulation
        self._observed = tuple(cameras)
        self._filmed = self._observed or (CameraParams(),)
        self._cameras: Sequence[Camera] = ()
        self.task = environment_id(robot, task)
        self.task_description = environment.simulation.task.instruction
        bounds: Any = environment.observation_space
        spaces: dict[str, gymnasium.Space[Any]] = {
            "agent_pos": _part(bounds, STATE),
            "environment_state": _part(bounds, ENVIRONMENT_STATE),
        }
        if self._observed:
            spaces["pixels"] = gymnasium.spaces.Dict(
                [(one.name, _picture(one)) for one in self._observed]
            )
        self.observation_space = gymnasium.spaces.Dict(spaces)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Start an episode, a random one of the use's without a seed.

        Raises:
            LfrError: there is no start of that number.
        """
        index = int(self.unwrapped.np_random.integers(PER_USE)) if seed is None else seed
        observation, info = self.env.reset(seed=episode_seed(self._seeds, index))
        return self._named(observation), info

    def step(self, action: Any) -> tuple[dict[str, Any], Any, bool, bool, dict[str, Any]]:
        observation, reward, diverged, truncated, info = self.env.step(action)
        return self._named(observation), reward, diverged or info["is_success"], truncated, info

    def render(self) -> Any:
        """What the first camera sees, (height, width, 3) uint8; black where OpenGL is missing.

        `lerobot-eval` films ten episodes and cannot be told not to.
        """
        if not _seeing():
            return np.zeros(_picture(self._filmed[0]).shape, np.uint8)
        return self._seen()[0].render(self._simulation)

    def close(self) -> None:
        for camera in self._cameras:
            camera.close()
        self._cameras = ()
        super().close()

    def _seen(self) -> Sequence[Camera]:
        if not self._cameras:
            from lfr.sim.camera import open_cameras

            there = self._simulation
            self._cameras = open_cameras(there.embodiment.name, there.task.name, self._filmed)
        return self._cameras

    def _named(self, observation: NDArray[np.float64]) -> dict[str, Any]:
        named: dict[str, Any] = {
            "agent_pos": observation[STATE],
            "environment_state": observation[ENVIRONMENT_STATE],
        }
        if self._observed:
            there = self._simulation
            named["pixels"] = {
                camera.name: np.ascontiguousarray(camera.render(there)) for camera in self._seen()
            }
        return named


def make_environment(horizon: int, **options: Any) -> gymnasium.Env[Any, Any]:
    """A `LeRobotEnvironment` cut at the horizon, which waits at its end for the next rollout.

    LeRobot steps a batch until its last episode is over, and stays within the horizon only if a
    wrapper tells it `_max_episode_steps`.
    """
    return FreezeAfterEpisodeEnd(TimeLimit(LeRobotEnvironment(**options), horizon))


@cache
def _seeing() -> bool:
    from lfr.sim.camera import camera_available

    if not camera_available():
        logging.warning("no OpenGL on this machine: the videos of episodes are black")
    return camera_available()


def _picture(camera: CameraParams) -> gymnasium.spaces.Box:
    return gymnasium.spaces.Box(0, 255, (camera.height, camera.width, 3), np.uint8)


def _part(space: gymnasium.spaces.Box, part: slice) -> gymnasium.spaces.Box:
    return gymnasium.spaces.Box(space.low[part], space.high[part], dtype=np.float64)
