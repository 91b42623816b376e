"""Gymnasium environments on the compiled engine: `lfr/Lift-Panda-v0` and its siblings.

    import gymnasium
    import lfr.sim.environment
    environment = gymnasium.make("lfr/Lift-Panda-v0")
    seen = gymnasium.make("lfr/Lift-Panda-v0", render_mode="rgb_array", camera="wrist")

An action is a `Box(-1, 1, (A,))`, the controller's (`lfr.embodiments.Embodiment.action`), an
observation the float64 vector of `lfr.tasks.Task.observation`, the reward robosuite's dense one in
[0, 1], or with `reward="sparse"` its sparse one, 1 while the task is solved. An episode ends
("terminated") when the physics diverges, with `info["diverged"]`, and is cut ("truncated") at the
task's horizon; success is `info["is_success"]` and ends nothing. `gymnasium.make_vec` gives many,
on all cores (`lfr.sim.vector`).
"""

from typing import Any, ClassVar, Literal, get_args

import gymnasium
import numpy as np
from gymnasium.envs.registration import register
from numpy.typing import NDArray

from lfr.controllers.controller import CONTROL_FREQUENCY
from lfr.embodiments import DEFAULT_CONTROLLER, Embodiment, embodiment, embodiments
from lfr.errors import UnknownNameError
from lfr.sim.camera_params import CameraParams
from lfr.sim.steps import Steps
from lfr.spaces import Space
from lfr.tasks import TASKS

Reward = Literal["dense", "sparse"]


def environment_id(name: str, task: str) -> str:
    """Gymnasium's name of an embodiment in a task, e.g. `lfr/Lift-UR5e-JointPosition-v0`.

    Raises:
        UnknownNameError: unknown embodiment.
    """
    body = embodiment(name)
    parts = [_camel(task), body.robot.title]
    if body.controller.name != DEFAULT_CONTROLLER:
        parts.append(_camel(body.controller.name))
    return f"lfr/{'-'.join(parts)}-v0"


def _camel(name: str) -> str:
    return "".join(word.capitalize() for word in name.split("_"))


class Environment(gymnasium.Env[NDArray[np.float64], NDArray[np.float32]]):
    """One embodiment in one task by Gymnasium's rules.

    Args:
        embodiment, task: as for `lfr.sim.simulation.Simulation`.
        reward: `dense` or `sparse`.
        render_mode: `rgb_array` draws what a camera sees, or None.
        camera, width, height: of the camera, as for `lfr.sim.camera_params.CameraParams`.
    """

    metadata: ClassVar[dict[str, Any]] = {
        "render_modes": ["rgb_array"],
        "render_fps": CONTROL_FREQUENCY,
    }

    def __init__(
        self,
        embodiment: str,
        task: str,
        reward: Reward = "dense",
        render_mode: str | None = None,
        camera: str = "agentview",
        width: int = 128,
        height: int = 128,
    ) -> None:
        # Registration must stay cheap; the engine imports MuJoCo and numba.
        from lfr.sim.simulation import Simulation

        self.simulation = Simulation(embodiment, task)
        self.render_mode = render_mode
        self._reward: Reward = checked_reward(reward)
        self.action_space: Any = action_space(self.simulation.embodiment)
        self.observation_space: Any = observation_space(self.simulation.layout)
        self._seen_by = CameraParams(camera, width, height)
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
        """What the camera sees (height, width, 3) uint8, or None without a render mode."""
        if self.render_mode is None:
            return None
        if self._camera is None:
            from lfr.sim.camera import Camera

            body, task, seen_by = self.simulation.embodiment, self.simulation.task, self._seen_by
            self._camera = Camera(body.name, task.name, seen_by.name, seen_by.width, seen_by.height)
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


def action_space(embodiment: Embodiment) -> gymnasium.spaces.Box:
    return gymnasium.spaces.Box(-1.0, 1.0, (embodiment.action.size,), np.float32)


def observation_space(layout: Space) -> gymnasium.spaces.Box:
    """Bounds (D,) that no sound observation leaves."""
    # A rotation matrix is orthonormal to rounding only, and an episode may fling things away.
    high = np.array([1.0 + 1e-6 if each.high <= 1.0 else 10.0 for each in layout.each()])
    return gymnasium.spaces.Box(-high, high, dtype=np.float64)


def register_environments() -> None:
    """Make all environments known to Gymnasium; importing this module does it."""
    for body in embodiments():
        for task in TASKS.values():
            name = environment_id(body.name, task.name)
            if name not in gymnasium.registry:
                register(
                    name,
                    entry_point="lfr.sim.environment:Environment",
                    vector_entry_point="lfr.sim.vector:VectorEnvironment",
                    max_episode_steps=task.horizon,
                    kwargs={"embodiment": body.name, "task": task.name},
                )


register_environments()
