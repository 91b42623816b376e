"""Where the gripper should go next, for each task, as a function of the observation alone.

A demonstrator that remembers its phase shows a learner actions that the state does not explain.
These waypoints have no memory: the phase is read from the state (the gripper's command says how
far a grasp has come), and approaches are funnels, so that the path is a smooth function of the
state and a disturbed arm simply joins it elsewhere.

All vectors are in the robot's base frame, metres and radians.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

OPEN, CLOSE = -1.0, 1.0
# The gripper's command, integrated over control steps, at which the fingers hold what they can.
GRASPED = 0.9
CLOSING = -0.85
# The gap between the fingers, m, below which they hold nothing. Hands close to 0 (Panda) and 0.013
# (Sawyer); the thinnest thing to hold, the nut's handle, keeps them 0.028 apart.
EMPTY = 0.02
# Horizontal distances in m, see `grasp`. Sawyer's fingers touch the table beside the nut's handle,
# and its friction would hold them where they came down.
CUBE_FUNNEL = (0.008, 0.03)
HANDLE_FUNNEL = (0.006, 0.02)
# A skill is carried out blindly for some steps, so what leaves millimetres to either side, the can
# between the fingers, the peg in its hole, is approached by this much at a time, m.
LOWERING = 0.006
# How far above or below the grasp point the fingers may close, m. At the last LOWERING the action
# is so weak that joint friction holds Panda's hand up to a centimetre above it.
RESTING = 0.012


@dataclass(frozen=True)
class Waypoint:
    """What the gripper should do now: move by ``delta`` (3,), turn by ``yaw``, open or close."""

    delta: np.ndarray
    yaw: float
    gripper: float


View = Callable[[str], np.ndarray]
"""Gives the slice of the observation that a quantity occupies, by its name."""


def grasp(
    view: View,
    to_grasp: np.ndarray,
    yaw: float,
    hover: float,
    funnel: tuple[float, float],
    slowly: bool = False,
) -> Waypoint | None:
    """Approach a grasp point from above and close there; None once it is held.

    ``to_grasp`` (3,) leads from the end effector to the grasp point, ``yaw`` is the turn that
    aligns the fingers. They come down from ``hover`` above it between the ``funnel``'s outer and
    inner horizontal distance; inside that they may wait, but never rise again. ``slowly`` arrives
    without speed across, and from the hover on comes down by LOWERING at a time.
    """
    command = float(view("gripper_command")[0])
    horizontal = float(np.hypot(to_grasp[0], to_grasp[1]))
    inner, outer = funnel
    at_grasp = horizontal < 0.018 and abs(to_grasp[2]) < 0.02
    if at_grasp and float(view("gripper_aperture")[0]) < EMPTY:  # closed beside it: rise, try again
        return Waypoint(np.array([0.0, 0.0, hover]), yaw, OPEN)
    if at_grasp and command > GRASPED:
        return None
    if at_grasp and command > CLOSING:
        return Waypoint(to_grasp, yaw, CLOSE)
    apart = max((horizontal - inner) / (outer - inner), (abs(yaw) - 0.1) / 0.4)
    height = float(to_grasp[2]) + hover * float(np.clip(apart, 0.0, 1.0))
    if horizontal < outer:
        height = min(height, 0.0)
    if horizontal < 0.02 and to_grasp[2] > -0.04:  # the fingers are down beside the object
        height = float(to_grasp[2])
    ready = horizontal < max(inner, 0.01) and abs(to_grasp[2]) < RESTING and abs(yaw) < 0.15
    move = np.array([to_grasp[0], to_grasp[1], height])
    if slowly:
        move[:2] *= _slowing(to_grasp)
        if to_grasp[2] > -1.2 * hover:
            move[2] = max(move[2], -LOWERING)
    return Waypoint(move, yaw, CLOSE if ready else OPEN)


def carry(
    to_goal: np.ndarray, clearance: float, funnel: tuple[float, float], askew: float = 0.0
) -> np.ndarray:
    """The move (3,) that brings a held object over its goal, then down: up first, across, lower.

    ``to_goal`` (3,) leads from the object to where it is let go; ``clearance`` is how high above
    that it travels, down to the ``funnel``'s inner horizontal distance. It moves across only as
    far as it has risen. ``askew`` from 0 to 1 holds it up while it still has to be turned.
    """
    horizontal = float(np.hypot(to_goal[0], to_goal[1]))
    inner, outer = funnel
    apart = max((horizontal - inner) / (outer - inner), askew)
    rise = float(to_goal[2]) + clearance * float(np.clip(apart, 0.0, 1.0))
    if horizontal < outer:  # near its goal it may wait, but not go up again
        rise = min(rise, 0.0)
    across = float(np.clip(1.3 - rise / 0.05, 0.0, 1.0))
    return np.array([across * to_goal[0], across * to_goal[1], rise])


def lift(view: View) -> Waypoint:
    waypoint = grasp(view, view("cube_to_eef"), _yaw(view("cube_yaw"), 4), 0.06, CUBE_FUNNEL)
    return waypoint or Waypoint(np.array([0.0, 0.0, 0.05]), 0.0, CLOSE)


def stack(view: View) -> Waypoint:
    rest = 0.045  # half of cube A (0.02) and of cube B (0.025), m
    to_goal = view("cubeA_to_cubeB") + np.array([0.0, 0.0, rest])
    over = np.hypot(to_goal[0], to_goal[1]) < 0.025
    if over and abs(to_goal[2]) < (0.02 if _letting_go(view) else 0.008):
        return _let_go(view)
    waypoint = grasp(view, view("cubeA_to_eef"), _yaw(view("cubeA_yaw"), 4), 0.06, CUBE_FUNNEL)
    return waypoint or Waypoint(carry(to_goal, 0.05, (0.006, 0.025)), 0.0, CLOSE)


def pick_place(view: View) -> Waypoint:
    release = 0.13  # the can's centre above the bin's floor when it is let go, m; it is 0.12 high
    # The compartment is 0.2 x 0.25 m and at the edge of the arms' reach: put the can down 5 cm
    # before its middle, where either arm comes to rest instead of passing by, and from a height
    # that it has on arrival.
    to_bin = view("can_to_bin")
    middle = view("can_pos")[:2] + to_bin[:2]
    before = 0.05 * middle / max(float(np.hypot(middle[0], middle[1])), 1e-9)
    to_goal = np.array([to_bin[0] - before[0], to_bin[1] - before[1], to_bin[2] + release])
    over = np.hypot(to_goal[0], to_goal[1]) < 0.04
    if over and -to_goal[2] < (0.08 if _letting_go(view) else 0.03):
        return _let_go(view)
    # Sawyer's fingers leave 4 mm on either side of the can: come down slowly, when well above it.
    waypoint = grasp(view, view("can_to_eef"), _level_yaw(view), 0.10, (0.005, 0.016), slowly=True)
    return waypoint or Waypoint(carry(to_goal, 0.06, (0.02, 0.06)), 0.0, CLOSE)


def nut_assembly(view: View) -> Waypoint:
    # The nut's height over the peg body's origin, m, where it is let go: the peg, 0.1 m high, is
    # well inside its hole by then, and it falls along it, where a hand might tilt it and jam.
    release = 0.045
    to_peg = view("nut_to_peg")
    over = np.hypot(to_peg[0], to_peg[1]) < 0.02
    if over and -to_peg[2] < release + (0.015 if _letting_go(view) else 0.0):
        return _let_go(view)
    handle = view("handle_to_eef") - view("nut_to_eef")  # from the nut's centre, 0.054 m
    # 8 mm further out, clear of the nut's body, and a little above the middle: it lies low.
    to_handle = view("handle_to_eef") + 0.15 * handle + np.array([0.0, 0.0, 0.003])
    # The fingers close across the handle, which points along the nut's x axis.
    across_handle = _yaw(-view("nut_yaw"), 2)
    waypoint = grasp(view, to_handle, across_handle, 0.06, HANDLE_FUNNEL)
    if waypoint:
        return waypoint
    align = _reachable(-_yaw(view("nut_peg_yaw"), 4), handle)
    to_goal = to_peg + np.array([0.0, 0.0, release - 0.02])
    askew = (abs(align) - 0.05) / 0.2  # never press a turned nut onto the peg
    move = carry(to_goal, 0.10, (0.005, 0.015), askew)
    move[:2] *= _slowing(to_goal)
    move[2] = max(move[2], -LOWERING)
    return Waypoint(move, align, CLOSE)


def _slowing(to_goal: np.ndarray) -> float:
    """The factor on a horizontal move ``to_goal`` that lets the hand arrive slowly, 0 to 1.

    A skill is carried out blindly: at full speed, 13 mm a step, one begun two steps late ends
    beyond the goal.
    """
    horizontal = float(np.hypot(to_goal[0], to_goal[1]))
    allowed = 0.008 + 0.3 * max(horizontal - 0.04, 0.0)
    return min(1.0, allowed / max(horizontal, 1e-9))


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


def _yaw(cos_sin: np.ndarray, symmetry: int) -> float:
    """The smallest turn (rad) that aligns the gripper with an object of ``symmetry`` folds."""
    return float(np.arctan2(cos_sin[1], cos_sin[0])) / symmetry


def _level_yaw(view: View) -> float:
    """The turn that brings the fingers' closing axis back along the base's y axis, modulo pi."""
    closing = view("eef_rot6d")[:2]  # x axis of the grip site, horizontal part
    return 0.5 * float(np.arctan2(2 * closing[0] * closing[1], closing[1] ** 2 - closing[0] ** 2))


def _letting_go(view: View) -> bool:
    """Whether the hand has begun to open: an arm that springs up must not make it close again."""
    return bool(view("gripper_command")[0] < GRASPED)


def _let_go(view: View) -> Waypoint:
    """Open, and once the fingers are on their way, rise straight up."""
    rise = 0.05 if view("gripper_command")[0] < -0.5 else 0.0
    return Waypoint(np.array([0.0, 0.0, rise]), 0.0, OPEN)


WAYPOINTS: dict[str, Callable[[View], Waypoint]] = {
    "lift": lift,
    "stack": stack,
    "pick_place": pick_place,
    "nut_assembly": nut_assembly,
}
