"""Where a gripper should go next, as a function of the observation alone: what tasks share.

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
        move[:2] *= slowing(to_grasp)
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


def slowing(to_goal: np.ndarray) -> float:
    """The factor on a horizontal move ``to_goal`` that lets the hand arrive slowly, 0 to 1.

    A skill is carried out blindly: at full speed, 13 mm a step, one begun two steps late ends
    beyond the goal.
    """
    horizontal = float(np.hypot(to_goal[0], to_goal[1]))
    allowed = 0.008 + 0.3 * max(horizontal - 0.04, 0.0)
    return min(1.0, allowed / max(horizontal, 1e-9))


def turn(cos_sin: np.ndarray, symmetry: int) -> float:
    """The smallest turn (rad) that aligns the gripper with an object of ``symmetry`` folds."""
    return float(np.arctan2(cos_sin[1], cos_sin[0])) / symmetry


def letting_go(view: View) -> bool:
    """Whether the hand has begun to open: an arm that springs up must not make it close again."""
    return bool(view("gripper_command")[0] < GRASPED)


def let_go(view: View) -> Waypoint:
    """Open, and once the fingers are on their way, rise straight up."""
    rise = 0.05 if view("gripper_command")[0] < -0.5 else 0.0
    return Waypoint(np.array([0.0, 0.0, rise]), 0.0, OPEN)
