"""Both simulators as Gymnasium environments, untouched but for what is said here.

`Sawyer-v0` is Meta-World's arm: its environments ignore the seed of `reset`, hide the goal unless
told, and draw objects and goals once; here they draw them at each reset, from its seed. `Fetch-v0`
is Gymnasium-Robotics' arm: FetchPush blocks the gripper, so pushing is FetchPickAndPlace with its
goals on the table, where the object may be dragged.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import gymnasium_robotics
import metaworld

gymnasium.register_envs(gymnasium_robotics)


class Seeded(gymnasium.Wrapper):
    """Meta-World's environment, whose resets follow from their seeds."""

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, Any]:
        if seed is not None:
            self.unwrapped.seed(seed)
        return self.env.reset(seed=seed, options=options)


def sawyer(task: str) -> gymnasium.Env:
    """Meta-World's Sawyer in one of its tasks, such as "push-v3"."""
    environment = metaworld.env_dict.ALL_V3_ENVIRONMENTS[task]()
    environment._partially_observable = False
    environment._freeze_rand_vec = False
    environment._set_task_called = True
    environment.seeded_rand_vec = True
    del environment.sawyer_observation_space
    return Seeded(environment)


def fetch(task: str) -> gymnasium.Env:
    """Gymnasium-Robotics' Fetch in "reach", "push" or "pick_place"."""
    name = "FetchReach-v4" if task == "reach" else "FetchPickAndPlace-v4"
    environment = gymnasium.make(name).env.env
    if task == "push":
        environment.unwrapped.target_in_the_air = False
    return environment


gymnasium.register("lfr-examples/Sawyer-v0", entry_point=sawyer, max_episode_steps=250)
gymnasium.register("lfr-examples/Fetch-v0", entry_point=fetch, max_episode_steps=50)
