"""Where a gripper's pads are in a model: the gap between their inner faces."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.robots import Gripper


def pad_geoms(model: Any, gripper: Gripper) -> NDArray[np.int64]:
    """(2, G): the geoms of the left and of the right pads, -1 where a side has fewer."""
    sides = (gripper.left_pads, gripper.right_pads)
    geoms = np.full((2, max(map(len, sides))), -1, dtype=np.int64)
    for side, names in enumerate(sides):
        geoms[side, : len(names)] = [model.geom(name).id for name in names]
    return geoms


def pad_depth(model: Any, gripper: Gripper) -> float:
    """From the pads' centres to their inner faces (m), of both sides together."""
    sides = (gripper.left_pads, gripper.right_pads)
    depths = [[model.geom(name).size[gripper.pad_axis] for name in names] for names in sides]
    return float(sum(map(np.mean, depths)))


def pad_gap(model: Any, data: Any, gripper: Gripper) -> float:
    """The gap (m) along the hand's closing axis; ``data`` has fresh kinematics."""
    closing = data.site(gripper.grip_site).xmat.reshape(3, 3)[:, 0]
    sides = (gripper.left_pads, gripper.right_pads)
    left, right = (np.mean([data.geom(name).xpos for name in names], axis=0) for names in sides)
    return float(abs((left - right) @ closing) - pad_depth(model, gripper))
