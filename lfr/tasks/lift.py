"""Lift: raise a cube, whose size differs from episode to episode, from the table."""

from __future__ import annotations

from typing import Any

import numpy as np

from lfr.compiled import compiled
from lfr.compiled.arrays import Physics, SceneArrays
from lfr.compiled.contacts import contacts
from lfr.compiled.frames import distance, row
from lfr.compiled.rewards import nearness
from lfr.tasks.task import Place, Sized, Task, manipulated_object
from lfr.tasks.waypoints import CLOSE, CUBE_FUNNEL, View, Waypoint, grasp, turn

CUBE = Place("body", "cube_main")
FOLD = 4

(TABLE_Z,) = range(1)
"""Of the task's constants: height of the table's top, m."""


def _constants(environment: Any) -> tuple[float, ...]:
    return (float(environment.table_offset[2]),)


@compiled
def _reward(physics: Physics, scene: SceneArrays) -> tuple[float, bool]:
    grasped, _ = contacts(physics, scene)
    cube = row(physics.xpos, scene.objects[0])
    if cube[2] > scene.constants[TABLE_Z] + 0.04:
        return 1.0, True
    reward = nearness(distance(row(physics.site_xpos, scene.grip_site), cube))
    if grasped:
        reward += 0.25
    return reward / 2.25, False


def _waypoint(view: View) -> Waypoint:
    waypoint = grasp(view, view("eef_to_cube"), turn(view("cube_yaw"), FOLD), 0.06, CUBE_FUNNEL)
    return waypoint or Waypoint(np.array([0.0, 0.0, 0.05]), 0.0, CLOSE)


LIFT = Task(
    name="lift",
    stock_name="Lift",
    horizon=150,
    instruction="lift the cube",
    objects={"cube": CUBE.name},
    places=(CUBE,),
    # robosuite/environments/manipulation/lift.py, where the bounds are literals
    sized=Sized(CUBE.name, 0.020, 0.022),
    terms=manipulated_object("cube", CUBE, FOLD),
    constants=_constants,
    reward=_reward,
    waypoint=_waypoint,
)
