"""Gymnasium environments on the compiled engine: `lfr/Lift-Panda-v0` and its seven siblings.

    import gymnasium
    import lfr.sim.environment
    environment = gymnasium.make("lfr/Lift-Panda-v0")

An action is a `Box(-1, 1, (7,))`, an observation the float64 vector of `lfr.sim.layout`, the reward
robosuite's dense one in [0, 1], or with `reward="sparse"` its sparse one, 1 while the task is
solved. An episode ends ("terminated") when the physics diverges, with `info["diverged"]`, and is
cut ("truncated") at the task's horizon; success is `info["is_success"]` and ends nothing.
`gymnasium.make_vec` gives many, on all cores (`lfr.sim.vector`).
"""

from typing import Any, ClassVar, Literal, get_args

import gymnasium
import numpy as np
from gymnasium.envs.registration import register
from numpy.typing import NDArray

from lfr.errors import UnknownNameError
from lfr.robots import ACTION_NAMES, ROBOTS
from lfr.sim.layout import ObservationLayout, Steps
from lfr.tasks import TASKS

Reward = Literal["dense", "sparse"]


def environment_id(robot: str, task: str) -> str:
    """Gymnasium's name of `robot` in `task`, e.g. `lfr/NutAssembly-Sawyer-v0`."""
    words = "".join(word.capitalize() for word in task.split("_"))
    return f"lfr/{words}-{robot.capitalize()}-v0"


class Environment(gymnasium.Env[NDArray[np.float64], NDArray[np.float32]]):
    """One arm in one task by Gymnasium's rules.

    Args:
        robot, task: as for `lfr.sim.simulation.Simulation`.
        reward: `dense` or `sparse`.
        render_mode: `rgb_array` draws the agent's view, or None.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(
        self, robot: str, task: str, reward: Reward = "dense", render_mode: str | None = None
    ) -> None:
        # Registration must stay cheap; the engine imports MuJoCo and numba.
        from lfr.sim.simulation import Simulation

        self.simulation = Simulation(robot, task)
        self.render_mode = render_mode
        self._reward: Reward = checked_reward(reward)
        self.action_space: Any = action_space()
        self.observation_space: Any = observation_space(self.simulation.layout)
        self._camera: Any = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float64], dict[str, Any]]:
        super().reset(seed=seed)
        start = int(self.np_random.integers(2**31)) if seed is None else seed
        return self.simulation.reset(start), {"seed": start}

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float64], float, bool, bool, dict[str, Any]]:
        steps = self.simulation.step(action)
        info = {"is_success": bool(steps.successes[-1]), "diverged": steps.diverged}
        return steps.observations[-1], earned(steps, self._reward), steps.diverged, False, info

    def render(self) -> Any:
        """The agent's view (128, 128, 3) uint8, or None without a render mode."""
        if self.render_mode is None:
            return None
        if self._camera is None:
            from lfr.sim.camera import Camera

            self._camera = Camera(self.simulation.robot.name, self.simulation.task.name)
        return self._camera.render(self.simulation)

    def close(self) -> None:
        if self._camera is not None:
            self._camera.close()
            self._camera = None


def checked_reward(reward: str) -> Reward:
    """`reward`, if there is one of that name.

    Raises:
        UnknownNameError: there is none.
    """
    if reward not in get_args(Reward):
        raise UnknownNameError("reward", reward, get_args(Reward))
    return "dense" if reward == "dense" else "sparse"


def earned(steps: Steps, reward: Reward) -> float:
    """The last step's reward."""
    return float(steps.rewards[-1] if reward == "dense" else steps.successes[-1])


def action_space() -> gymnasium.spaces.Box:
    return gymnasium.spaces.Box(-1.0, 1.0, (len(ACTION_NAMES),), np.float32)


def observation_space(layout: ObservationLayout) -> gymnasium.spaces.Box:
    """Bounds (D,): 1 for directions, cosines and commands, 10 m for lengths."""
    unit = ("eef_rot6d", "gripper_command")
    bounded = [
        name.split(".")[0] in unit or "_up." in name or "_yaw." in name for name in layout.names
    ]
    # A rotation matrix is orthonormal to rounding only.
    high = np.where(bounded, 1.0 + 1e-6, 10.0)
    return gymnasium.spaces.Box(-high, high, dtype=np.float64)


def register_environments() -> None:
    """Make the eight environments known to Gymnasium; importing this module does it."""
    for robot in ROBOTS.values():
        for task in TASKS.values():
            name = environment_id(robot.name, task.name)
            if name not in gymnasium.registry:
                register(
                    name,
                    entry_point="lfr.sim.environment:Environment",
                    vector_entry_point="lfr.sim.vector:VectorEnvironment",
                    max_episode_steps=task.horizon,
                    kwargs={"robot": robot.name, "task": task.name},
                )


register_environments()
