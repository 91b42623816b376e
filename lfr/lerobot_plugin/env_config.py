"""`--env.type=lfr`: this project's environments for LeRobot's scripts."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Any, get_args

import gymnasium
from gymnasium.vector import AutoresetMode
from lerobot.configs import FeatureType, PolicyFeature
from lerobot.envs.configs import EnvConfig
from lerobot.utils.constants import ACTION, OBS_ENV_STATE, OBS_IMAGES, OBS_STATE

from lfr.data.episode import FPS
from lfr.errors import ParameterError, UnknownNameError
from lfr.lerobot_plugin.configuration_lfr import features_of
from lfr.lerobot_plugin.environment import make_environment
from lfr.seeds import Use
from lfr.sim.camera_params import CameraParams, check_names
from lfr.sim.environment import checked_reward
from lfr.tasks import task


@EnvConfig.register_subclass("lfr")
@dataclass
class LfrEnv(EnvConfig):
    """`--env.type=lfr --env.robot=panda --env.task=lift`.

    Attributes:
        robot, task: of `lfr.embodiments` and `lfr.tasks`, such as `ur5e-joint_position`; there is
            no default, for any other than a policy's own would judge it wrongly.
        reward: `dense` or `sparse`.
        seeds: whose starts the seeds number (`lfr.seeds`). LeRobot's `--seed=0` then is the first
            held-out start, and no seed is a demonstration's.
        cameras: observe `observation.images.<camera>` of these too, said as `record.cameras` of
            params.yaml: `--env.cameras='[{name: agentview}, {name: wrist, width: 64}]'`; needs
            OpenGL.
    """

    robot: str = ""
    task: str | None = None
    fps: int = FPS
    reward: str = "dense"
    seeds: str = "held-out"
    cameras: list[CameraParams] = field(default_factory=list)
    features: dict[str, PolicyFeature] = field(default_factory=dict)
    features_map: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Raises ParameterError or UnknownNameError for what there is not."""
        if not self.robot or not self.task:
            raise ParameterError("say which: --env.robot=panda --env.task=lift, or another")
        checked_reward(self.reward)
        if self.seeds not in get_args(Use):
            raise UnknownNameError("use of seeds", self.seeds, get_args(Use))
        given, answered = features_of(self.robot, self.task)
        self.features = {
            "agent_pos": given[OBS_STATE],
            "environment_state": given[OBS_ENV_STATE],
            **answered,
        }
        self.features_map = {
            "agent_pos": OBS_STATE,
            "environment_state": OBS_ENV_STATE,
            ACTION: ACTION,
        }
        check_names(self.cameras)
        for camera in self.cameras:
            key = f"{OBS_IMAGES}.{camera.name}"
            shape = camera.height, camera.width, 3
            self.features[key] = PolicyFeature(FeatureType.VISUAL, shape)
            self.features_map[key] = key

    @property
    def gym_kwargs(self) -> dict[str, Any]:
        return {
            "robot": self.robot,
            "task": self.task,
            "reward": self.reward,
            "seeds": self.seeds,
            "cameras": self.cameras,
        }

    def create_envs(
        self, n_envs: int, use_async_envs: bool = False
    ) -> dict[str, dict[int, gymnasium.vector.VectorEnv]]:
        """`n_envs` of them in one batch, each in a process of its own if asked to."""
        make = partial(make_environment, task(self.task or "").horizon, **self.gym_kwargs)
        # Finished environments wait (FreezeAfterEpisodeEnd), which needs this mode.
        mode = AutoresetMode.NEXT_STEP
        if use_async_envs and n_envs > 1:
            batch = gymnasium.vector.AsyncVectorEnv(
                [make] * n_envs, context="forkserver", autoreset_mode=mode
            )
        else:
            batch = gymnasium.vector.SyncVectorEnv([make] * n_envs, autoreset_mode=mode)
        return {self.type: {0: batch}}
