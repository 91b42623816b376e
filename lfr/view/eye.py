"""Where the 3-D view is seen from: as near as shows all that moves, always from the same side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

TOWARDS_EYE = np.array([0.74, -0.55, 0.38])
"""From what is looked at to the eye, in the world: before the table, a little to its side and
above. The hand and the objects are nearest then, and the arm behind them hides neither."""

FIELD_OF_VIEW = np.deg2rad(55.0)
"""rerun's vertical field of view (`re_view_spatial`, `Eye::DEFAULT_FOV_Y`)."""

MARGIN = 0.16
"""m kept around every point: bodies are known by their origins, and have an extent."""


@dataclass(frozen=True)
class Eye:
    """Position of the eye and the point that it looks at, (3,) each, in the world (m)."""

    position: NDArray[np.float64]
    target: NDArray[np.float64]


def eye_on(points: ArrayLike) -> Eye:
    """The nearest eye that has all points (N, 3), in the world (m), in a square picture.

    A point that lies `u` to a side of the target and `n` nearer than it is in the picture of an eye
    at the distance `d` that looks `c` to that side if |u - c| <= t (d - n), t the tangent of half
    the field of view; the least such d and its c follow for each of the picture's two axes.
    """
    table = np.asarray(points, dtype=np.float64)
    back = TOWARDS_EYE / np.linalg.norm(TOWARDS_EYE)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(back, right), back])  # rows: right, up, towards the eye
    seen = table @ axes.T
    depth = (seen[:, 2].min() + seen[:, 2].max()) / 2
    tangent = np.tan(FIELD_OF_VIEW / 2)
    nearness = tangent * (seen[:, 2:] - depth)  # (N, 1)
    high = np.max(seen[:, :2] + nearness, axis=0) + MARGIN
    low = np.max(-seen[:, :2] + nearness, axis=0) + MARGIN
    distance = np.max(high + low) / (2 * tangent)
    target = np.array([*(high - low) / 2, depth], dtype=np.float64) @ axes
    return Eye((target + distance * back).astype(np.float64), target)
