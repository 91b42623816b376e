"""What a controller is: its action, its compiled code, and its twin in robosuite."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from lfr.robots.robot import Robot
from lfr.spaces import Quantity, Space, gripper_action


@dataclass(frozen=True)
class Controller:
    """Turns an action (A,) in [-1, 1], the gripper's last, into torques.

    Attributes:
        name: this project's name of it, such as "osc_pose".
        stock_name: robosuite's name of it.
        motion: of an arm, the quantities of the action but for the gripper.
        set_goal: compiled, (physics, scene, control, action): once for a control step.
        set_torques: compiled, (physics, scene, control): at every physics step.
        stock_gains: what robosuite's configuration of it says beside the scales.
    """

    name: str
    stock_name: str
    motion: Callable[[Robot], tuple[Quantity, ...]]
    set_goal: Callable[..., None]
    set_torques: Callable[..., None]
    stock_gains: dict[str, Any]

    def space(self, robot: Robot) -> Space:
        """The action of this controller on an arm."""
        return Space((*self.motion(robot), gripper_action()))

    def about(self, robot: Robot) -> str:
        """The action in words, for a dataset."""
        parts = []
        for quantity in self.space(robot).quantities:
            sizes = ", ".join(f"{value:g}" for value in dict.fromkeys(quantity.scale))
            parts.append(f"{quantity.about} x {sizes} {quantity.unit}" if sizes else quantity.about)
        return f"in [-1, 1]: {'; '.join(parts)}"

    def scale(self, robot: Robot) -> tuple[float, ...]:
        """(A - 1,) what an action of 1 asks for, in each dimension's unit, the gripper aside."""
        return tuple(value for quantity in self.motion(robot) for value in quantity.scale)

    def stock_config(self, robot: Robot) -> dict[str, Any]:
        """robosuite's configuration of the same controller, for `robosuite.make`."""
        scale = list(self.scale(robot))
        arm = {
            "type": self.stock_name,
            "input_max": 1,
            "input_min": -1,
            "output_max": scale,
            "output_min": [-value for value in scale],
            "input_type": "delta",
            "interpolation": None,
            "gripper": {"type": "GRIP"},
            **self.stock_gains,
        }
        return {"type": "BASIC", "body_parts": {"right": arm}}
