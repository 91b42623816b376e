"""A batch of environments by Gymnasium's rules for vector environments, on several threads.

    import gymnasium
    import lfr.sim.environment
    environments = gymnasium.make_vec("lfr/Lift-Panda-v0", num_envs=16)

Seeds, time limits, infos and autoreset (the mode `NEXT_STEP`) are those of Gymnasium's own
`SyncVectorEnv` over single environments; the tests hold the two equal.
"""

from __future__ import annotations

from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from lfr.controllers.controller import CONTROL_FREQUENCY
from lfr.errors import UnknownNameError
from lfr.sim.batch import Batch
from lfr.sim.environment import (
    Reward,
    action_space,
    checked_reward,
    earned,
    observation_space,
)

Array = NDArray[Any]


class VectorEnvironment(gymnasium.vector.VectorEnv[Array, Array, Array]):
    """`num_envs` environments of one embodiment in one task.

    An episode whose physics diverges ends ("terminated", `info["diverged"]`); the others go on.

    Args:
        num_envs: how many.
        embodiment, task, reward: as for `lfr.sim.environment.Environment`.
        max_episode_steps: control steps after which an episode is cut; the task's horizon if None.
        threads: at most so many at a time; every core of this process if None.
        render_mode: `rgb_array` draws each one's agent's view, or None.

    Raises:
        UnknownNameError: unknown embodiment, task, reward or render mode.
    """

    metadata: ClassVar[dict[str, Any]] = {
        "autoreset_mode": AutoresetMode.NEXT_STEP,
        "render_modes": ["rgb_array"],
        "render_fps": CONTROL_FREQUENCY,
    }

    def __init__(
        self,
        num_envs: int,
        embodiment: str,
        task: str,
        reward: Reward = "dense",
        max_episode_steps: int | None = None,
        threads: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise UnknownNameError("render mode", render_mode, self.metadata["render_modes"])
        self.render_mode = render_mode
        self._camera: Any = None
        self._batch = Batch(embodiment, task, num_envs, threads)
        self._reward: Reward = checked_reward(reward)
        self._limit = max_episode_steps or self._batch.horizon
        self.num_envs = num_envs
        self.single_action_space = action_space(self._batch.embodiment)
        self.single_observation_space = observation_space(self._batch.layout)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._generators = [seeding.np_random()[0] for _ in range(num_envs)]
        self._observations = np.zeros((num_envs, self._batch.layout.size))
        self._lengths = np.zeros(num_envs, dtype=np.int64)
        self._over = np.zeros(num_envs, dtype=np.bool_)

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Array, dict[str, Any]]:
        """Start episodes: in all, or with `options["reset_mask"]` (N,) bool in some."""
        if isinstance(seed, int):
            seeds: list[int | None] = [seed + i for i in range(self.num_envs)]
        else:
            seeds = [None] * self.num_envs if seed is None else list(seed)
        if len(seeds) != self.num_envs:
            raise ValueError(f"{len(seeds)} seeds for {self.num_envs} environments")
        chosen = (options or {}).get("reset_mask", np.ones(self.num_envs, dtype=np.bool_))
        infos: dict[str, Any] = {}
        for i in np.flatnonzero(chosen):
            infos = self._start(int(i), seeds[i], infos)
        return self._observations.copy(), infos

    def step(self, actions: Array) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        """One control step; where an episode is over, a new one starts and the action is unused."""
        if np.shape(actions) != self.action_space.shape:
            raise ValueError(
                f"actions have shape {np.shape(actions)}, expected {self.action_space.shape}"
            )
        rewards = np.zeros(self.num_envs)
        terminated, truncated = np.zeros((2, self.num_envs), dtype=np.bool_)
        going, infos = np.flatnonzero(~self._over), {}
        done = dict(zip(going, self._batch.step_some(going, actions[going, None]), strict=True))
        for i in range(self.num_envs):
            if i not in done:
                infos = self._start(i, None, infos)
                continue
            steps = done[i]
            self._observations[i] = steps.observations[-1]
            self._lengths[i] += 1
            rewards[i] = earned(steps, self._reward)
            terminated[i] = steps.diverged
            truncated[i] = self._lengths[i] >= self._limit
            info = {"is_success": bool(steps.successes[-1]), "diverged": steps.diverged}
            infos = self._add_info(infos, info, i)
        self._over = terminated | truncated
        return self._observations.copy(), rewards, terminated, truncated, infos

    def render(self) -> tuple[Array, ...] | None:
        """Of each its agent's view (128, 128, 3) uint8, or None without a render mode."""
        if self.render_mode is None:
            return None
        if self._camera is None:
            from lfr.sim.camera import Camera

            self._camera = Camera(self._batch.embodiment.name, self._batch.task.name)
        return tuple(self._camera.render(each) for each in self._batch.simulations)

    def close_extras(self, **_: Any) -> None:
        self._batch.close()
        if self._camera is not None:
            self._camera.close()
            self._camera = None

    def _start(self, i: int, seed: int | None, infos: dict[str, Any]) -> dict[str, Any]:
        if seed is not None:
            self._generators[i] = seeding.np_random(seed)[0]
        start = int(self._generators[i].integers(2**31)) if seed is None else seed
        self._observations[i] = self._batch.simulations[i].reset(start)
        self._lengths[i], self._over[i] = 0, False
        return self._add_info(infos, {"seed": start}, i)
