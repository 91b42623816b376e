"""The observation vector, for the compiled kernel: the arm's state, then the task's terms.

A function of the joint positions and the gripper command alone: all poses come fresh from
`mj_kinematics`, while stock robosuite's lag them by one substep.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lfr.compiled.arrays import Control, Physics, SceneArrays
from lfr.compiled.frames import axes_of, column_in_base, in_base, position_of, yaw_in_base
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
    rotation = physics.site_xmat[scene.grip_site]
    in_base(physics, scene, physics.site_xpos[scene.grip_site], out, 0)
    column_in_base(physics, scene, rotation, 0, out, 3)
    column_in_base(physics, scene, rotation, 1, out, 6)
    out[9] = aperture(physics, scene)
    out[10] = control.gripper[0]
    at = STATE_SIZE
    for term in range(scene.term_kind.shape[0]):
        at += _observe_term(physics, scene, term, out, at)


@compiled
def aperture(physics: Physics, scene: SceneArrays) -> float:
    """Gap (m) between the inner faces of the pads, along the closing axis of the hand."""
    axes, apart = physics.site_xmat[scene.grip_site], 0.0
    for k in range(3):
        centre = _pad_centre(physics, scene, 1, k) - _pad_centre(physics, scene, 0, k)
        apart += axes[3 * k] * centre
    return abs(apart) - scene.pad_depth


@compiled
def _pad_centre(physics: Physics, scene: SceneArrays, side: int, axis: int) -> float:
    total, count = 0.0, 0
    for i in range(scene.pad_geoms.shape[1]):
        geom = scene.pad_geoms[side, i]
        if geom >= 0:
            total += physics.geom_xpos[geom, axis]
            count += 1
    return total / count


@compiled
def _observe_term(
    physics: Physics, scene: SceneArrays, term: int, out: NDArray[np.float64], at: int
) -> int:
    """Write one term to ``out[at:]``; returns its size."""
    kind, to, origin = scene.term_kind[term], scene.term_to[term], scene.term_from[term]
    if kind == YAW:
        yaw = yaw_in_base(physics, scene, axes_of(physics, scene, to))
        reference = yaw_in_base(physics, scene, axes_of(physics, scene, origin))
        angle = scene.term_fold[term] * (yaw - reference)
        out[at], out[at + 1] = math.cos(angle), math.sin(angle)
        return 2
    if kind == AXIS:
        column_in_base(physics, scene, axes_of(physics, scene, to), 2, out, at)
        return 3
    in_base(physics, scene, position_of(physics, scene, to), out, at)
    if kind == DISPLACEMENT:
        x, y, z = out[at], out[at + 1], out[at + 2]
        in_base(physics, scene, position_of(physics, scene, origin), out, at)
        out[at], out[at + 1], out[at + 2] = x - out[at], y - out[at + 1], z - out[at + 2]
    return 3
