"""The arms that the project knows, one file each; a new one is a file and an entry here."""

from __future__ import annotations

from lfr.errors import UnknownNameError
from lfr.robots.panda import PANDA
from lfr.robots.robot import Gripper, Robot
from lfr.robots.sawyer import SAWYER

__all__ = ["ROBOTS", "Gripper", "Robot", "robot"]

ROBOTS: dict[str, Robot] = {one.name: one for one in (PANDA, SAWYER)}


def robot(name: str) -> Robot:
    """The robot called `name`.

    Raises:
        UnknownNameError: there is none; the message lists those there are.
    """
    if name not in ROBOTS:
        raise UnknownNameError("robot", name, tuple(ROBOTS))
    return ROBOTS[name]
