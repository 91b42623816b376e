"""The observation vector, for the compiled kernel: the arm's state, then the task's terms.

A function of the joint positions and the gripper command alone: all poses come fresh from
`mj_kinematics`, while stock robosuite's lag them by one substep.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lfr.compiled.arrays import Control, Physics, SceneArrays
from lfr.compiled.frames import (
    Vector,
    axis_of,
    column,
    point_in_base,
    position_of,
    row,
    vector_in_base,
    yaw_in_base,
)
from lfr.compiled.marking import compiled

POSITION, AXIS, DISPLACEMENT, YAW = range(4)
"""Kinds of term: position (3,), own z axis (3,), vector from one place to another (3,), and cosine
and sine (2,) of k (psi - psi_from), k the rotational symmetry of what is turned."""

STATE_SIZE = 11


@compiled
def observe(
    physics: Physics, scene: SceneArrays, control: Control, out: NDArray[np.float64]
) -> None:
    """Write the observation (D,) into `out`; the kinematics must be up to date."""
    hand = scene.grip_site
    _write(out, 0, point_in_base(physics, scene, row(physics.site_xpos, hand)))
    _write(out, 3, vector_in_base(physics, scene, column(physics.site_xmat, hand, 0)))
    _write(out, 6, vector_in_base(physics, scene, column(physics.site_xmat, hand, 1)))
    out[9] = aperture(physics, scene)
    out[10] = control.gripper[0]
    at = STATE_SIZE
    for term in range(scene.term_kind.shape[0]):
        at += _observe_term(physics, scene, term, out, at)


@compiled
def aperture(physics: Physics, scene: SceneArrays) -> float:
    """Gap (m) between the inner faces of the pads, along the closing axis of the hand."""
    x, y, z = column(physics.site_xmat, scene.grip_site, 0)
    left, right = _pad_centre(physics, scene, 0), _pad_centre(physics, scene, 1)
    apart = x * (right[0] - left[0]) + y * (right[1] - left[1]) + z * (right[2] - left[2])
    return abs(apart) - scene.pad_depth


@compiled
def _pad_centre(physics: Physics, scene: SceneArrays, side: int) -> Vector:
    x, y, z, count = 0.0, 0.0, 0.0, 0
    for i in range(scene.pad_geoms.shape[1]):
        geom = scene.pad_geoms[side, i]
        if geom >= 0:
            x += physics.geom_xpos[geom, 0]
            y += physics.geom_xpos[geom, 1]
            z += physics.geom_xpos[geom, 2]
            count += 1
    return x / count, y / count, z / count


@compiled
def _observe_term(
    physics: Physics, scene: SceneArrays, term: int, out: NDArray[np.float64], at: int
) -> int:
    """Write one term to ``out[at:]``; returns its size."""
    kind, to, origin = scene.term_kind[term], scene.term_to[term], scene.term_from[term]
    if kind == YAW:
        yaw = yaw_in_base(physics, scene, axis_of(physics, scene, to, 0))
        reference = yaw_in_base(physics, scene, axis_of(physics, scene, origin, 0))
        angle = scene.term_fold[term] * (yaw - reference)
        out[at], out[at + 1] = math.cos(angle), math.sin(angle)
        return 2
    if kind == AXIS:
        _write(out, at, vector_in_base(physics, scene, axis_of(physics, scene, to, 2)))
        return 3
    x, y, z = point_in_base(physics, scene, position_of(physics, scene, to))
    if kind == DISPLACEMENT:
        a, b, c = point_in_base(physics, scene, position_of(physics, scene, origin))
        x, y, z = x - a, y - b, z - c
    _write(out, at, (x, y, z))
    return 3


@compiled
def _write(out: NDArray[np.float64], at: int, vector: Vector) -> None:
    out[at], out[at + 1], out[at + 2] = vector[0], vector[1], vector[2]
