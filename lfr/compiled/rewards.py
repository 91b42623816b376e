"""What robosuite's dense rewards have in common, for the compiled kernel.

Source: robosuite 1.5.2, `environments/manipulation`, with `reward_shaping=True` and
`reward_scale=1.0`. Like stock, they read poses and contacts of the last substep's start.
"""

from __future__ import annotations

import math

from lfr.compiled.marking import compiled

REACH, GRASP, LIFTED, HOVER = 0.1, 0.35, 0.5, 0.7
"""Largest rewards of the stages of PickPlace and NutAssembly."""


@compiled
def nearness(distance: float) -> float:
    """1 - tanh(10 d): 1 there, 0 far away."""
    return 1.0 - math.tanh(10.0 * distance)


@compiled
def staged(
    z: float, lift_z: float, reach: float, grasped: bool, apart: float, above: bool
) -> float:
    """Largest of the stages reach, grasp, lift and hover; `apart` is the distance to the goal."""
    grasp = GRASP if grasped else 0.0
    lift = 0.0
    if grasped:
        below = max(lift_z - z, 0.0)
        lift = GRASP + (1.0 - math.tanh(15.0 * below)) * (LIFTED - GRASP)
    hover = (LIFTED if above else lift) + nearness(apart) * (HOVER - LIFTED)
    return max(nearness(reach) * REACH, grasp, lift, hover)
