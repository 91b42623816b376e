"""The controllers that the project knows, one file each; a new one is a file and an entry here."""

from __future__ import annotations

import math
from typing import Any

from lfr.compiled import compiled, select
from lfr.compiled.arrays import SceneArrays
from lfr.controllers.controller import Controller
from lfr.controllers.joint_position import JOINT_POSITION
from lfr.controllers.osc_pose import OSC_POSE
from lfr.errors import UnknownNameError

__all__ = ["CONTROLLERS", "Controller", "controller", "set_goal", "set_torques"]

CONTROLLERS: dict[str, Controller] = {one.name: one for one in (OSC_POSE, JOINT_POSITION)}


def controller(name: str) -> Controller:
    """The controller called ``name``.

    Raises:
        UnknownNameError: there is none; the message lists those there are.
    """
    if name not in CONTROLLERS:
        raise UnknownNameError("controller", name, CONTROLLERS)
    return CONTROLLERS[name]


@compiled
def _number(scene: SceneArrays) -> int:
    return scene.controller


@compiled
def _without_goal(physics: Any, scene: Any, control: Any, action: Any) -> None:
    pass


@compiled
def _without_torques(physics: Any, scene: Any, control: Any) -> None:
    physics.qvel[0] = math.nan  # an unknown controller diverges, and is seen


_ALL = tuple(CONTROLLERS.values())
set_goal = select([one.set_goal for one in _ALL], _number, _without_goal)
set_torques = select([one.set_torques for one in _ALL], _number, _without_torques)
