"""The observation vector, for the compiled kernel; its names are in `lfr.sim.layout`.

A function of the joint positions and the gripper command alone: all poses come fresh from
`mj_kinematics`, while stock robosuite's lag them by one substep.
"""

import math

import numpy as np
from numpy.typing import NDArray

from lfr.sim.compilation import compiled
from lfr.sim.libmujoco import Physics
from lfr.sim.osc import Controller
from lfr.sim.scene import SceneArrays

LIFT, STACK, PICK_PLACE, NUT_ASSEMBLY = range(4)
"""`Task.identifier` of the four tasks."""


@compiled
def observe(
    physics: Physics, scene: SceneArrays, control: Controller, out: NDArray[np.float64]
) -> None:
    """Write the observation (D,) into `out`; the kinematics must be up to date."""
    rotation = physics.site_xmat[scene.grip_site]
    body = physics.xmat[scene.first_object]
    _relative(physics, scene, physics.site_xpos[scene.grip_site], out, 0)
    _column(physics, scene, rotation, 0, out, 3)
    _column(physics, scene, rotation, 1, out, 6)
    aperture = physics.qpos[scene.finger_first] - physics.qpos[scene.finger_second]
    out[9] = aperture + scene.pad_gap_at_zero
    out[10] = control.gripper[0]

    _relative(physics, scene, physics.xpos[scene.first_object], out, 11)
    _column(physics, scene, body, 2, out, 14)
    _difference(out, 11, 0, out, 17)
    if scene.task == LIFT:
        _yaw(physics, scene, body, rotation, 4.0, out, 20)
    elif scene.task == STACK:
        _yaw(physics, scene, body, rotation, 4.0, out, 20)
        _relative(physics, scene, physics.xpos[scene.second_object], out, 22)
        _difference(out, 22, 11, out, 25)
    elif scene.task == PICK_PLACE:
        _relative(physics, scene, scene.bin_target, out, 20)
        _difference(out, 20, 11, out, 20)
    else:
        _yaw(physics, scene, body, rotation, 2.0, out, 20)
        _relative(physics, scene, physics.site_xpos[scene.handle_site], out, 22)
        _difference(out, 22, 0, out, 22)
        _relative(physics, scene, physics.xpos[scene.peg_body], out, 25)
        _difference(out, 25, 11, out, 25)
        _yaw(physics, scene, body, physics.xmat[scene.peg_body], 4.0, out, 28)


@compiled
def _relative(
    physics: Physics,
    scene: SceneArrays,
    point: NDArray[np.float64],
    out: NDArray[np.float64],
    at: int,
) -> None:
    """A world point (3,) in the base frame."""
    base, origin = physics.xmat[scene.base_body], physics.xpos[scene.base_body]
    for i in range(3):
        out[at + i] = 0.0
        for k in range(3):
            out[at + i] += base[3 * k + i] * (point[k] - origin[k])


@compiled
def _column(
    physics: Physics,
    scene: SceneArrays,
    matrix: NDArray[np.float64],
    column: int,
    out: NDArray[np.float64],
    at: int,
) -> None:
    """A column of a rotation matrix (9,), in the base frame."""
    base = physics.xmat[scene.base_body]
    for i in range(3):
        out[at + i] = 0.0
        for k in range(3):
            out[at + i] += base[3 * k + i] * matrix[3 * k + column]


@compiled
def _difference(
    source: NDArray[np.float64], first: int, second: int, out: NDArray[np.float64], at: int
) -> None:
    for i in range(3):
        out[at + i] = source[first + i] - source[second + i]


@compiled
def _yaw(
    physics: Physics,
    scene: SceneArrays,
    matrix: NDArray[np.float64],
    reference: NDArray[np.float64],
    symmetry: float,
    out: NDArray[np.float64],
    at: int,
) -> None:
    """cos and sin of k (psi - psi_reference), psi the yaw of an x axis about the base's z."""
    angle = symmetry * (_psi(physics, scene, matrix) - _psi(physics, scene, reference))
    out[at], out[at + 1] = math.cos(angle), math.sin(angle)


@compiled
def _psi(physics: Physics, scene: SceneArrays, matrix: NDArray[np.float64]) -> float:
    base = physics.xmat[scene.base_body]
    x = base[0] * matrix[0] + base[3] * matrix[3] + base[6] * matrix[6]
    y = base[1] * matrix[0] + base[4] * matrix[3] + base[7] * matrix[6]
    return math.atan2(y, x)
