"""What a controller is: its action, its compiled code, and its twin in robosuite."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.robots.robot import Robot
from lfr.spaces import Quantity, Space, gripper_action

CONTROL_FREQUENCY = 20
"""Hz; an action holds for a control step of 50 ms."""

SUBSTEPS = 25
"""Physics steps, of robosuite's 2 ms, in a control step."""

TRANSLATION_UNIT = 0.05
ROTATION_UNIT = 0.5
"""m and rad: a hand motion of 1. It is what OSC_POSE's action of 1 asks for in robosuite."""

HAND_UNITS = np.repeat([TRANSLATION_UNIT, ROTATION_UNIT], 3)
"""(6,), of translation above rotation."""


@dataclass(frozen=True)
class Configuration:
    """Where an arm stands, as far as a controller must know it to move the hand.

    Attributes:
        joint_position: (N,) rad.
        rest: (N,) rad, the posture that it starts from and comes back to where the task lets it.
        jacobian: (6, N) of the grip site, translation above rotation, in the base frame.
        scale: (A - 1,) what an action of 1 asks for.
    """

    joint_position: NDArray[np.float64]
    rest: NDArray[np.float64]
    jacobian: NDArray[np.float64]
    scale: NDArray[np.float64]


@dataclass(frozen=True)
class Controller:
    """Turns an action (A,) in [-1, 1], the gripper's last, into torques.

    Attributes:
        name: this project's name of it, such as "osc_pose".
        stock_name: robosuite's name of it.
        motion: of an arm, the quantities of the action but for the gripper.
        set_goal: compiled, (physics, scene, control, action): once for a control step.
        set_torques: compiled, (physics, scene, control): at every physics step.
        action_of: the action but for the gripper, (A - 1,) in [-1, 1], that moves the hand as a
            demonstrator wants it: (hand motion (6,), `Configuration`). The motion is a translation
            and a rotation vector in the base frame, in units of `TRANSLATION_UNIT` and
            `ROTATION_UNIT`.
        stock_gains: what robosuite's configuration of it says beside the scales.
    """

    name: str
    stock_name: str
    motion: Callable[[Robot], tuple[Quantity, ...]]
    set_goal: Callable[..., None]
    set_torques: Callable[..., None]
    action_of: Callable[[NDArray[np.float64], Configuration], NDArray[np.float64]]
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

    def label(
        self, motion: NDArray[np.float64], configuration: Configuration
    ) -> NDArray[np.float64]:
        """The action (A,) for a hand motion and a gripper action (7,)."""
        return np.append(self.action_of(motion[:-1], configuration), motion[-1])

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
