"""Points and axes in the arm's base frame, for the compiled kernel.

A place is a body, a site, or a point that stays where it is.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lfr.compiled.arrays import Physics, SceneArrays
from lfr.compiled.marking import compiled

BODY, SITE, POINT = range(3)
"""Kinds of place: what `SceneArrays.place_id` counts, if anything."""


@compiled
def position_of(physics: Physics, scene: SceneArrays, place: int) -> NDArray[np.float64]:
    """Position (3,) of a place, m, world frame."""
    if scene.place_kind[place] == BODY:
        return physics.xpos[scene.place_id[place]]
    if scene.place_kind[place] == SITE:
        return physics.site_xpos[scene.place_id[place]]
    return scene.place_point[place]


@compiled
def axes_of(physics: Physics, scene: SceneArrays, place: int) -> NDArray[np.float64]:
    """Rotation matrix (9,), row by row, of a body or a site, world frame."""
    if scene.place_kind[place] == SITE:
        return physics.site_xmat[scene.place_id[place]]
    return physics.xmat[scene.place_id[place]]


@compiled
def in_base(
    physics: Physics,
    scene: SceneArrays,
    point: NDArray[np.float64],
    out: NDArray[np.float64],
    at: int,
) -> None:
    """Write a world point (3,) in the base frame to ``out[at : at + 3]``."""
    base, origin = physics.xmat[scene.base_body], physics.xpos[scene.base_body]
    for i in range(3):
        out[at + i] = 0.0
        for k in range(3):
            out[at + i] += base[3 * k + i] * (point[k] - origin[k])


@compiled
def column_in_base(
    physics: Physics,
    scene: SceneArrays,
    matrix: NDArray[np.float64],
    column: int,
    out: NDArray[np.float64],
    at: int,
) -> None:
    """Write a column of a rotation matrix (9,) in the base frame to ``out[at : at + 3]``."""
    base = physics.xmat[scene.base_body]
    for i in range(3):
        out[at + i] = 0.0
        for k in range(3):
            out[at + i] += base[3 * k + i] * matrix[3 * k + column]


@compiled
def yaw_in_base(physics: Physics, scene: SceneArrays, matrix: NDArray[np.float64]) -> float:
    """Yaw psi (rad) of the x axis of a rotation matrix (9,) about the base's z axis."""
    base = physics.xmat[scene.base_body]
    x = base[0] * matrix[0] + base[3] * matrix[3] + base[6] * matrix[6]
    y = base[1] * matrix[0] + base[4] * matrix[3] + base[7] * matrix[6]
    return math.atan2(y, x)
