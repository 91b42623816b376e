"""robosuite's dense rewards and success checks, for the compiled kernel.

Source: robosuite 1.5.2, `environments/manipulation/{lift,stack,pick_place,nut_assembly}.py`, with
`reward_shaping=True` and `reward_scale=1.0`. Like stock, they read poses and contacts of the last
substep's start. One departure: stock parks unused objects 10 m away and counts them in the lifting
term, which is therefore complete during the 1.3 s until they have fallen; here they do not exist.
"""

import math

import numpy as np
from numpy.typing import NDArray

from lfr.sim.compilation import compiled
from lfr.sim.libmujoco import MAX_CONTACTS, Physics
from lfr.sim.observation import LIFT, PICK_PLACE, STACK
from lfr.sim.scene import FIRST_OBJECT, LEFT_PAD, RIGHT_PAD, SECOND_OBJECT, SceneArrays

REACH, GRASP, LIFTED, HOVER = 0.1, 0.35, 0.5, 0.7
"""Largest rewards of the stages of PickPlace and NutAssembly."""


@compiled
def reward_and_success(physics: Physics, scene: SceneArrays) -> tuple[float, bool]:
    """Dense reward and success of the state that the last substep started from."""
    grasped, stacked = _contacts(physics, scene)
    eef = physics.site_xpos[scene.grip_site]
    position = physics.xpos[scene.first_object]
    if scene.task == LIFT:
        return _lift(scene, position, _distance(eef, position), grasped)
    if scene.task == STACK:
        other = physics.xpos[scene.second_object]
        return _stack(scene, position, other, _distance(eef, position), grasped, stacked)
    if scene.task == PICK_PLACE:
        return _pick_place(scene, position, _distance(eef, position), grasped)
    handle, peg = physics.site_xpos[scene.handle_site], physics.xpos[scene.peg_body]
    return _nut_assembly(
        scene, position, peg, _distance(eef, position), _distance(eef, handle), grasped
    )


@compiled
def _contacts(physics: Physics, scene: SceneArrays) -> tuple[bool, bool]:
    """Whether both pads touch the first object, and whether the two objects touch."""
    left = right = stacked = False
    for c in range(min(physics.contact_count[0], MAX_CONTACTS)):
        first, second = physics.contact_geoms[c, 0], physics.contact_geoms[c, 1]
        if first < 0 or second < 0:
            continue
        a, b = scene.geom_kind[first], scene.geom_kind[second]
        if a > b:
            a, b = b, a
        left |= a == LEFT_PAD and b == FIRST_OBJECT
        right |= a == RIGHT_PAD and b == FIRST_OBJECT
        stacked |= a == FIRST_OBJECT and b == SECOND_OBJECT
    return left and right, stacked


@compiled
def _distance(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@compiled
def _near(distance: float) -> float:
    return 1.0 - math.tanh(10.0 * distance)


@compiled
def _lift(
    scene: SceneArrays, position: NDArray[np.float64], distance: float, grasped: bool
) -> tuple[float, bool]:
    if position[2] > scene.surface_z + 0.04:
        return 1.0, True
    reward = _near(distance)
    if grasped:
        reward += 0.25
    return reward / 2.25, False


@compiled
def _stack(
    scene: SceneArrays,
    position: NDArray[np.float64],
    other: NDArray[np.float64],
    distance: float,
    grasped: bool,
    touching: bool,
) -> tuple[float, bool]:
    reach = _near(distance) * 0.25 + (0.25 if grasped else 0.0)
    lift = 0.0
    if position[2] > scene.surface_z + 0.04:
        apart = math.hypot(position[0] - other[0], position[1] - other[1])
        lift = 1.0 + 0.5 * (1.0 - math.tanh(apart))
    success = not grasped and lift > 0.0 and touching
    return max(reach, lift, 2.0 if success else 0.0) / 2.0, success


@compiled
def _staged(
    scene: SceneArrays, z: float, reach: float, grasped: bool, apart: float, above: bool
) -> float:
    """Largest of the stages reach, grasp, lift and hover; `apart` is the distance to the goal."""
    grasp = GRASP if grasped else 0.0
    lift = 0.0
    if grasped:
        below = max(scene.lift_z - z, 0.0)
        lift = GRASP + (1.0 - math.tanh(15.0 * below)) * (LIFTED - GRASP)
    hover = (LIFTED if above else lift) + _near(apart) * (HOVER - LIFTED)
    return max(_near(reach) * REACH, grasp, lift, hover)


@compiled
def _pick_place(
    scene: SceneArrays, position: NDArray[np.float64], distance: float, grasped: bool
) -> tuple[float, bool]:
    dx, dy = position[0] - scene.bin_target[0], position[1] - scene.bin_target[1]
    above = abs(dx) < scene.bin_size[0] / 2 and abs(dy) < scene.bin_size[1] / 2
    inside = above and scene.surface_z < position[2] < scene.surface_z + 0.1
    if inside and _near(distance) < 0.6:
        return 1.0, True
    return _staged(scene, position[2], distance, grasped, math.hypot(dx, dy), above), False


@compiled
def _nut_assembly(
    scene: SceneArrays,
    position: NDArray[np.float64],
    peg: NDArray[np.float64],
    distance: float,
    handle_distance: float,
    grasped: bool,
) -> tuple[float, bool]:
    dx, dy = position[0] - peg[0], position[1] - peg[1]
    on_peg = abs(dx) < 0.03 and abs(dy) < 0.03 and position[2] < scene.surface_z + 0.05
    if on_peg and _near(distance) < 0.6:
        return 1.0, True
    return _staged(scene, position[2], handle_distance, grasped, math.hypot(dx, dy), False), False
