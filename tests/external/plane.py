"""The puck's own environment, as somebody might have written it who has never heard of lfr."""

from __future__ import annotations

import os
from typing import Any

import gymnasium
import numpy as np

FPS, STEP, NEAR = 10, 0.05, 0.1
BROKEN_AT = 7  # control steps, where it is asked to break


class Plane(gymnasium.Env):
    """Hand and goal in metres; the hand's command, speed and heading.

    Args:
        quadrant: where the goals lie.
        breaks: in each episode: "raises", or "exits" with its whole process; True raises.
        broken: the method that does nothing but raise.
        drifts: does not repeat itself from a seed.
        box: observes the vector itself, in no dictionary.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": FPS}  # noqa: RUF012  (Gymnasium's convention)
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (4,), np.float32)
    task_description = "park it"
    task = "park"

    def __init__(
        self, quadrant: tuple[int, int] = (1, -1), breaks: bool | str = False,
        drifts: bool = False, box: bool = False, success: str = "is_success", broken: str = "",
        render_mode: str | None = None,
    ) -> None:  # fmt: skip
        self.quadrant, self.breaks, self.drifts, self.box = quadrant, breaks, drifts, box
        self.success, self.broken, self.render_mode = success, broken, render_mode
        vector = gymnasium.spaces.Box(-9.0, 9.0, (4,), np.float32)
        self.observation_space = vector if box else gymnasium.spaces.Dict({"agent_pos": vector})

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, Any]:
        super().reset(seed=seed)
        if self.broken == "reset":
            raise RuntimeError("no licence")
        self.steps = 0
        self.hand = self.np_random.uniform(-0.1, 0.1, 2)
        self.goal = self.np_random.uniform(0.4, 0.8, 2) * self.quadrant
        if self.drifts:
            self.hand += np.random.default_rng().uniform(-0.01, 0.01, 2)
        return self._seen(), {}

    def step(self, action: np.ndarray) -> tuple[Any, float, bool, bool, Any]:
        self.steps += 1
        if self.broken == "step":
            raise RuntimeError("no licence")
        if self.breaks and self.steps == BROKEN_AT:
            if self.breaks == "exits":
                os._exit(3)  # as a segmentation fault would end it
            raise RuntimeError("the puck has left the plane")
        _, speed, *heading = np.clip(action, -1, 1)
        self.hand = self.hand + (speed + 1) / 2 * STEP * np.array(heading)
        there = bool(np.linalg.norm(self.goal - self.hand) < NEAR)
        return self._seen(), float(there), there, False, {self.success: there}

    def render(self) -> Any:
        return np.full((32, 48, 3), 8 * self.steps, np.uint8)

    def _seen(self) -> Any:
        vector = np.concatenate([self.hand, self.goal]).astype(np.float32)
        return vector if self.box else {"agent_pos": vector}


gymnasium.register("lfr-test/Plane-v0", entry_point=Plane, max_episode_steps=40)
