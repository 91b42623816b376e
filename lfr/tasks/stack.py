"""Stack: put the red cube A on the green cube B."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lfr.compiled import compiled
from lfr.compiled.arrays import Physics, SceneArrays
from lfr.compiled.contacts import contacts
from lfr.compiled.frames import distance, row
from lfr.compiled.rewards import nearness
from lfr.tasks.task import Place, Task, displacement, manipulated_object, position
from lfr.tasks.waypoints import (
    CLOSE,
    CUBE_FUNNEL,
    View,
    Waypoint,
    carry,
    grasp,
    let_go,
    letting_go,
    turn,
)

CUBE_A = Place("body", "cubeA_main")
CUBE_B = Place("body", "cubeB_main")
FOLD = 4

(TABLE_Z,) = range(1)
"""Of the task's constants: height of the table's top, m."""


def _constants(environment: Any) -> tuple[float, ...]:
    return (float(environment.table_offset[2]),)


@compiled
def _reward(physics: Physics, scene: SceneArrays) -> tuple[float, bool]:
    grasped, touching = contacts(physics, scene)
    cube, other = row(physics.xpos, scene.objects[0]), row(physics.xpos, scene.objects[1])
    near = nearness(distance(row(physics.site_xpos, scene.grip_site), cube))
    reach = near * 0.25 + (0.25 if grasped else 0.0)
    lift = 0.0
    if cube[2] > scene.constants[TABLE_Z] + 0.04:
        apart = math.hypot(cube[0] - other[0], cube[1] - other[1])
        lift = 1.0 + 0.5 * (1.0 - math.tanh(apart))
    success = not grasped and lift > 0.0 and touching
    return max(reach, lift, 2.0 if success else 0.0) / 2.0, success


def _waypoint(view: View) -> Waypoint:
    rest = 0.045  # half of cube A (0.02) and of cube B (0.025), m
    to_goal = view("cubeA_to_cubeB") + np.array([0.0, 0.0, rest])
    over = np.hypot(to_goal[0], to_goal[1]) < 0.025
    if over and abs(to_goal[2]) < (0.02 if letting_go(view) else 0.008):
        return let_go(view)
    waypoint = grasp(view, view("eef_to_cubeA"), turn(view("cubeA_yaw"), FOLD), 0.06, CUBE_FUNNEL)
    return waypoint or Waypoint(carry(to_goal, 0.05, (0.006, 0.025)), 0.0, CLOSE)


STACK = Task(
    name="stack",
    stock_name="Stack",
    horizon=250,
    instruction="stack the red cube on the green cube",
    objects={"cubeA": CUBE_A.name, "cubeB": CUBE_B.name},
    places=(CUBE_A, CUBE_B),
    terms=(
        *manipulated_object("cubeA", CUBE_A, FOLD),
        position("cubeB", CUBE_B),
        displacement("cubeA", CUBE_A, "cubeB", CUBE_B),
    ),
    constants=_constants,
    reward=_reward,
    waypoint=_waypoint,
)
