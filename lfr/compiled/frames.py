"""Points and axes in the arm's base frame, for the compiled kernel.

A place is a body, a site, or a point that stays where it is. A vector is a tuple of numbers here:
compiled code keeps it in registers, where a slice of an array would be counted as a reference.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lfr.compiled.arrays import Physics, SceneArrays
from lfr.compiled.marking import compiled

type Vector = tuple[float, float, float]

BODY, SITE, POINT = range(3)
"""Kinds of place: what `SceneArrays.place_id` counts, if anything."""


@compiled
def position_of(physics: Physics, scene: SceneArrays, place: int) -> Vector:
    """Position of a place, m, world frame."""
    kind, i = scene.place_kind[place], scene.place_id[place]
    if kind == BODY:
        return row(physics.xpos, i)
    if kind == SITE:
        return row(physics.site_xpos, i)
    return row(scene.place_point, place)


@compiled
def axis_of(physics: Physics, scene: SceneArrays, place: int, axis: int) -> Vector:
    """An axis (0, 1, 2 for x, y, z) of a body or a site, world frame."""
    i = scene.place_id[place]
    if scene.place_kind[place] == SITE:
        return column(physics.site_xmat, i, axis)
    return column(physics.xmat, i, axis)


@compiled
def row(array: NDArray[np.float64], i: int) -> Vector:
    """The i-th of an array of points (n, 3)."""
    return array[i, 0], array[i, 1], array[i, 2]


@compiled
def column(matrices: NDArray[np.float64], i: int, axis: int) -> Vector:
    """A column of the i-th of an array of rotation matrices (n, 9)."""
    return matrices[i, axis], matrices[i, 3 + axis], matrices[i, 6 + axis]


@compiled
def point_in_base(physics: Physics, scene: SceneArrays, point: Vector) -> Vector:
    """A point, given and returned in m, from the world to the base frame."""
    x, y, z = row(physics.xpos, scene.base_body)
    return vector_in_base(physics, scene, (point[0] - x, point[1] - y, point[2] - z))


@compiled
def vector_in_base(physics: Physics, scene: SceneArrays, vector: Vector) -> Vector:
    """A direction from the world to the base frame."""
    x, y, z = vector
    ax, ay, az = column(physics.xmat, scene.base_body, 0)
    bx, by, bz = column(physics.xmat, scene.base_body, 1)
    cx, cy, cz = column(physics.xmat, scene.base_body, 2)
    return ax * x + ay * y + az * z, bx * x + by * y + bz * z, cx * x + cy * y + cz * z


@compiled
def yaw_in_base(physics: Physics, scene: SceneArrays, axis: Vector) -> float:
    """Yaw psi (rad) of a direction, given in the world frame, about the base's z axis."""
    x, y, _ = vector_in_base(physics, scene, axis)
    return math.atan2(y, x)


@compiled
def distance(a: Vector, b: Vector) -> float:
    """Between two points, m."""
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)
