"""The arm's joint-space inertia, for controllers."""

from __future__ import annotations

from lfr.compiled import compiled
from lfr.compiled.arrays import Control, Physics, SceneArrays


@compiled
def inertia(physics: Physics, scene: SceneArrays, control: Control) -> int:
    """Fill ``control.mass`` (N, N) from MuJoCo's sparse matrix; returns N."""
    M = control.mass
    joints = M.shape[0]
    for i in range(joints):
        for j in range(i + 1):
            M[i, j] = M[j, i] = physics.inertia[scene.inertia_index[i, j]]
    return joints
