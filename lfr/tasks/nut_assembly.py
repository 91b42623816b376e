"""Nut assembly: put the square nut onto its square peg."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lfr.compiled import compiled
from lfr.compiled.arrays import Physics, SceneArrays
from lfr.compiled.contacts import contacts
from lfr.compiled.frames import distance, position_of, row
from lfr.compiled.rewards import nearness, staged
from lfr.tasks.task import EEF, Place, Task, displacement, manipulated_object, yaw
from lfr.tasks.waypoints import (
    CLOSE,
    HANDLE_FUNNEL,
    LOWERING,
    View,
    Waypoint,
    carry,
    grasp,
    let_go,
    letting_go,
    slowing,
    turn,
)

NUT = Place("body", "SquareNut_main")
HANDLE = Place("site", "SquareNut_handle_site")
PEG = Place("body", "peg1")
PLACES = (NUT, HANDLE, PEG)
HANDLE_NUMBER, PEG_NUMBER = (1 + PLACES.index(place) for place in (HANDLE, PEG))
NUT_FOLD, PEG_FOLD = 2, 4

TABLE_Z, LIFT_Z = range(2)
"""Of the task's constants, m: the table's height, the height that completes the lifting reward."""


def _constants(environment: Any) -> tuple[float, ...]:
    table = environment.sim.data.get_body_xpos("table")
    return (float(environment.table_offset[2]), float(table[2] + 0.2))


@compiled
def _reward(physics: Physics, scene: SceneArrays) -> tuple[float, bool]:
    """One departure from stock, as in `lfr.tasks.pick_place`."""
    grasped, _ = contacts(physics, scene)
    nut, numbers = row(physics.xpos, scene.objects[0]), scene.constants
    eef = row(physics.site_xpos, scene.grip_site)
    peg = position_of(physics, scene, PEG_NUMBER)
    dx, dy = nut[0] - peg[0], nut[1] - peg[1]
    on_peg = abs(dx) < 0.03 and abs(dy) < 0.03 and nut[2] < numbers[TABLE_Z] + 0.05
    if on_peg and nearness(distance(eef, nut)) < 0.6:
        return 1.0, True
    reach = distance(eef, position_of(physics, scene, HANDLE_NUMBER))
    return staged(nut[2], numbers[LIFT_Z], reach, grasped, math.hypot(dx, dy), False), False


def _waypoint(view: View) -> Waypoint:
    # The nut's height over the peg body's origin, m, where it is let go: the peg, 0.1 m high, is
    # well inside its hole by then, and it falls along it, where a hand might tilt it and jam.
    release = 0.045
    to_peg = view("nut_to_peg")
    over = np.hypot(to_peg[0], to_peg[1]) < 0.02
    if over and -to_peg[2] < release + (0.015 if letting_go(view) else 0.0):
        return let_go(view)
    handle = view("eef_to_handle") - view("eef_to_nut")  # from the nut's centre, 0.054 m
    # 8 mm further out, clear of the nut's body, and a little above the middle: it lies low.
    to_handle = view("eef_to_handle") + 0.15 * handle + np.array([0.0, 0.0, 0.003])
    # The fingers close across the handle, which points along the nut's x axis.
    across_handle = turn(-view("nut_yaw"), NUT_FOLD)
    waypoint = grasp(view, to_handle, across_handle, 0.06, HANDLE_FUNNEL)
    if waypoint:
        return waypoint
    align = _reachable(-turn(view("nut_peg_yaw"), PEG_FOLD), handle)
    to_goal = to_peg + np.array([0.0, 0.0, release - 0.02])
    askew = (abs(align) - 0.05) / 0.2  # never press a turned nut onto the peg
    move = carry(to_goal, 0.10, (0.005, 0.015), askew)
    move[:2] *= slowing(to_goal)
    move[2] = max(move[2], -LOWERING)
    return Waypoint(move, align, CLOSE)


def _reachable(align: float, handle: np.ndarray) -> float:
    """The turn (rad) that fits the nut to its peg without taking the hand to the peg's far side.

    ``align`` is the smallest turn; any quarter turn more fits as well. ``handle`` (3,) leads from
    the nut's centre to its handle. Beyond the peg, 0.84 m from its base, Panda is stretched out:
    its hand tilts and the nut jams.
    """
    angle = float(np.arctan2(handle[1], handle[0]))
    if np.cos(angle + align) < 0.7:
        return align
    return align + (0.5 * np.pi if angle > 0.0 else -0.5 * np.pi)


NUT_ASSEMBLY = Task(
    name="nut_assembly",
    stock_name="NutAssemblySquare",
    horizon=300,
    instruction="put the square nut onto its peg",
    objects={"nut": NUT.name},
    places=PLACES,
    terms=(
        *manipulated_object("nut", NUT, NUT_FOLD),
        displacement("eef", EEF, "handle", HANDLE),
        displacement("nut", NUT, "peg", PEG),
        yaw("nut_peg", "nut", NUT, PEG_FOLD, PEG, "peg"),
    ),
    constants=_constants,
    reward=_reward,
    waypoint=_waypoint,
    unused_objects=("RoundNut_main",),
)
