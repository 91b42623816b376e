"""An embodiment: an arm, its gripper and the controller that its actions belong to.

It is known by one name, which datasets, logs, models and results carry: the arm's, then whatever is
not the default, such as "panda", "ur5e" or "ur5e-joint_position".
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

from lfr.controllers import CONTROLLERS, Controller, controller
from lfr.errors import UnknownNameError
from lfr.robots import ROBOTS, Gripper, Robot, robot
from lfr.spaces import Space

DEFAULT_CONTROLLER = "osc_pose"


@dataclass(frozen=True)
class Embodiment:
    """An arm with its gripper under one controller."""

    robot: Robot
    controller: Controller

    @property
    def name(self) -> str:
        """The arm's name, and the controller's where it is not `DEFAULT_CONTROLLER`."""
        standard = self.controller.name == DEFAULT_CONTROLLER
        return self.robot.name if standard else f"{self.robot.name}-{self.controller.name}"

    @property
    def gripper(self) -> Gripper:
        return self.robot.gripper

    @property
    def action(self) -> Space:
        """`action`, (A,) in [-1, 1]: the controller's, and the gripper last."""
        return self.controller.space(self.robot)

    @property
    def action_scale(self) -> tuple[float, ...]:
        """(A - 1,) what an action of 1 asks for, in each dimension's unit, the gripper aside."""
        return self.controller.scale(self.robot)

    @property
    def stock_config(self) -> dict[str, Any]:
        """robosuite's configuration of the controller."""
        return self.controller.stock_config(self.robot)

    def shares_actions(self, other: Embodiment) -> bool:
        """Whether an action of one is the same thing for the other.

        Motions of the hand are, on any two arms; motions of an arm's own joints are its alone, also
        where another's joints have the same names.
        """
        own = any(quantity.moves == "with the base" for quantity in self.action.quantities)
        return self.controller == other.controller and (self.robot == other.robot or not own)


@cache
def embodiment(name: str) -> Embodiment:
    """The embodiment called ``name``.

    Raises:
        UnknownNameError: no such arm or controller; the message lists those there are.
    """
    arm, *rest = name.split("-")
    chosen = robot(arm)
    others = [one for one in CONTROLLERS if one != DEFAULT_CONTROLLER]
    if len(rest) > 1 or (rest and rest[0] not in others):
        raise UnknownNameError("embodiment", name, (arm, *(f"{arm}-{one}" for one in others)))
    return Embodiment(chosen, controller(rest[0] if rest else DEFAULT_CONTROLLER))


def is_known(name: str) -> bool:
    """Whether there is an embodiment called ``name``."""
    return any(one.name == name for one in embodiments())


@cache
def known_action(names: tuple[str, ...], name: str = "") -> Space | None:
    """The action whose dimensions are called ``names``; None where no embodiment here has it.

    Args:
        name: of the embodiment, where it is said. Motions of the hand are the same on any arm;
            motions of an arm's own joints are known by its name alone.
    """
    for one in embodiments():
        own = any(quantity.moves == "with the base" for quantity in one.action.quantities)
        if one.action.names == names and (one.name == name or not own):
            return one.action
    return None


def may_share_actions(first: str, second: str) -> bool:
    """`Embodiment.shares_actions` by name; of an arm that is not simulated nothing is known."""
    if not (is_known(first) and is_known(second)):
        return True
    return embodiment(first).shares_actions(embodiment(second))


def embodiments() -> Iterator[Embodiment]:
    """Every arm under every controller."""
    for arm in ROBOTS.values():
        for one in CONTROLLERS.values():
            yield Embodiment(arm, one)
