"""The arms that the project knows, one file each; a new one is a file and an entry here."""

from __future__ import annotations

from lfr.errors import UnknownNameError
from lfr.robots.iiwa import IIWA
from lfr.robots.jaco import JACO
from lfr.robots.kinova3 import KINOVA3
from lfr.robots.panda import PANDA
from lfr.robots.robot import Gripper, Robot
from lfr.robots.sawyer import SAWYER
from lfr.robots.ur5e import UR5E
from lfr.robots.xarm7 import XARM7

__all__ = ["ROBOTS", "Gripper", "Robot", "robot"]

_ALL = (PANDA, SAWYER, UR5E, IIWA, KINOVA3, XARM7, JACO)
ROBOTS: dict[str, Robot] = {one.name: one for one in _ALL}


def robot(name: str) -> Robot:
    """The robot called `name`.

    Raises:
        UnknownNameError: there is none; the message lists those there are.
    """
    if name not in ROBOTS:
        raise UnknownNameError("robot", name, tuple(ROBOTS))
    return ROBOTS[name]
