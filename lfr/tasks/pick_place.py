"""Pick and place: take the can out of its bin and put it into its own compartment beside it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.compiled import compiled
from lfr.compiled.arrays import Physics, SceneArrays
from lfr.compiled.contacts import contacts
from lfr.compiled.frames import distance, row
from lfr.compiled.rewards import nearness, staged
from lfr.tasks.task import Place, Task, displacement, manipulated_object
from lfr.tasks.waypoints import CLOSE, View, Waypoint, carry, grasp, let_go, letting_go

CAN = Place("body", "Can_main")
BIN = Place("point", "bin")

FLOOR_Z, LIFT_Z, BIN_X, BIN_Y, HALF_X, HALF_Y = range(6)
"""Of the task's constants, m: height of the bin's floor, height that completes the lifting reward,
centre and half sizes of the can's compartment."""


def _compartment(environment: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centre (3,) and sizes (2,) of the can's compartment, one of four."""
    size = np.array(environment.bin_size[:2], dtype=np.float64) / 2
    return np.array(environment.bin2_pos, np.float64) + np.array([*size / 2, 0.0]), size


def _constants(environment: Any) -> tuple[float, ...]:
    centre, size = _compartment(environment)
    floor = float(environment.bin2_pos[2])
    return (floor, floor + 0.25, centre[0], centre[1], size[0] / 2, size[1] / 2)


@compiled
def _reward(physics: Physics, scene: SceneArrays) -> tuple[float, bool]:
    """One departure from stock: that parks unused objects 10 m away and counts them as lifted.

    Its lifting term is therefore complete during the 1.3 s until they have fallen.
    """
    grasped, _ = contacts(physics, scene)
    can, numbers = row(physics.xpos, scene.objects[0]), scene.constants
    reach = distance(row(physics.site_xpos, scene.grip_site), can)
    dx, dy = can[0] - numbers[BIN_X], can[1] - numbers[BIN_Y]
    above = abs(dx) < numbers[HALF_X] and abs(dy) < numbers[HALF_Y]
    inside = above and numbers[FLOOR_Z] < can[2] < numbers[FLOOR_Z] + 0.1
    if inside and nearness(reach) < 0.6:
        return 1.0, True
    return staged(can[2], numbers[LIFT_Z], reach, grasped, math.hypot(dx, dy), above), False


def _waypoint(view: View) -> Waypoint:
    release = 0.13  # the can's centre above the bin's floor when it is let go, m; it is 0.12 high
    # The compartment is 0.2 x 0.25 m and at the edge of the arms' reach: put the can down 5 cm
    # before its middle, where an arm comes to rest instead of passing by, and from a height
    # that it has on arrival.
    to_bin = view("can_to_bin")
    middle = view("can_pos")[:2] + to_bin[:2]
    before = 0.05 * middle / max(float(np.hypot(middle[0], middle[1])), 1e-9)
    to_goal = np.array([to_bin[0] - before[0], to_bin[1] - before[1], to_bin[2] + release])
    over = np.hypot(to_goal[0], to_goal[1]) < 0.04
    if over and -to_goal[2] < (0.08 if letting_go(view) else 0.03):
        return let_go(view)
    # Sawyer's fingers leave 4 mm on either side of the can: come down slowly, when well above it.
    waypoint = grasp(view, view("eef_to_can"), _level_yaw(view), 0.10, (0.005, 0.016), slowly=True)
    return waypoint or Waypoint(carry(to_goal, 0.06, (0.02, 0.06)), 0.0, CLOSE)


def _level_yaw(view: View) -> float:
    """The turn that brings the fingers' closing axis back along the base's y axis, modulo pi."""
    closing = view("eef_rot6d")[:2]  # x axis of the grip site, horizontal part
    return 0.5 * float(np.arctan2(2 * closing[0] * closing[1], closing[1] ** 2 - closing[0] ** 2))


PICK_PLACE = Task(
    name="pick_place",
    stock_name="PickPlaceCan",
    horizon=300,
    instruction="pick the can and place it into its bin",
    objects={"can": CAN.name},
    places=(CAN, BIN),
    terms=(*manipulated_object("can", CAN), displacement("can", CAN, "bin", BIN)),
    constants=_constants,
    points=lambda environment: {BIN.name: _compartment(environment)[0]},
    reward=_reward,
    waypoint=_waypoint,
    unused_objects=("Milk_main", "Bread_main", "Cereal_main"),
)
