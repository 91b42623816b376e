"""What compiled code is given of one simulation: physics, scene and controller, as arrays.

The same types for every arm, gripper, controller and task, so that one compiled specialisation
serves all of them: what differs is data. N arm joints, F finger joints, P finger actuators, R
places, T observed terms, C constants of the task.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Physics(NamedTuple):
    """Pointers to one MuJoCo model and its data, and views of what the kernel reads and writes."""

    model: int
    data: int
    qpos: NDArray[np.float64]  # (nq,)
    qvel: NDArray[np.float64]  # (nv,)
    ctrl: NDArray[np.float64]  # (nu,)
    bias: NDArray[np.float64]  # (nv,) gravity, Coriolis and centrifugal forces
    inertia: NDArray[np.float64]  # (nM,) sparse joint-space inertia matrix
    xanchor: NDArray[np.float64]  # (njnt, 3)
    xaxis: NDArray[np.float64]  # (njnt, 3)
    xpos: NDArray[np.float64]  # (nbody, 3)
    xmat: NDArray[np.float64]  # (nbody, 9)
    geom_xpos: NDArray[np.float64]  # (ngeom, 3)
    site_xpos: NDArray[np.float64]  # (nsite, 3)
    site_xmat: NDArray[np.float64]  # (nsite, 9)
    contact_count: NDArray[np.int32]  # (1,)
    contact_geoms: NDArray[np.int32]  # (MAX_CONTACTS, 2)


class SceneArrays(NamedTuple):
    """What the kernel must know of a scene. Lengths in m, world frame."""

    task: int  # number in lfr.tasks
    controller: int  # number in lfr.controllers
    base_body: int
    controller_site: int  # whose axes the Cartesian controller's action is given in
    grip_site: int
    objects: NDArray[np.int64]  # (2,) bodies that a grasp or a contact is asked of, -1 for none
    geom_kind: NDArray[np.int64]  # (ngeom,) see lfr.compiled.contacts
    pad_geoms: NDArray[np.int64]  # (2, G) of the left and the right pads, -1 where fewer
    pad_depth: float  # from the pads' centres to their inner faces, both sides together
    ctrl_range: NDArray[np.float64]  # (nu, 2)
    close_signs: NDArray[np.float64]  # (P,) of the finger actuators
    finger_speed: float  # of the gripper's command per control step
    inertia_index: NDArray[np.int64]  # (N, N) places of the arm's block in MjData.qM
    action_scale: NDArray[np.float64]  # (A - 1,) of the controller, per unit of action
    place_kind: NDArray[np.int64]  # (R,) see lfr.compiled.frames
    place_id: NDArray[np.int64]  # (R,)
    place_point: NDArray[np.float64]  # (R, 3) of a fixed one
    term_kind: NDArray[np.int64]  # (T,) see lfr.compiled.observation
    term_to: NDArray[np.int64]  # (T,) place
    term_from: NDArray[np.int64]  # (T,) place that it is relative to
    term_fold: NDArray[np.float64]  # (T,) rotational symmetry
    constants: NDArray[np.float64]  # (C,) numbers of the task, in its own order


class Control(NamedTuple):
    """What a controller remembers, and room to compute in."""

    posture: NDArray[np.float64]  # (N,) joint position at the episode's start
    gripper: NDArray[np.float64]  # (1,) integrated command in [-1, 1], +1 closed
    goal_position: NDArray[np.float64]  # (3,) x_d, world frame
    goal_rotation: NDArray[np.float64]  # (3, 3) R_d, world frame
    goal_joints: NDArray[np.float64]  # (N,) q_d
    jacobian: NDArray[np.float64]  # (6, N) of the grip site
    mass: NDArray[np.float64]  # (N, N) M
    factor: NDArray[np.float64]  # (N, N) lower Cholesky factor of M
    half: NDArray[np.float64]  # (N, 6) factor^-1 J^T, so that J M^-1 J^T = half^T half
    operational: NDArray[np.float64]  # (6, 6) J M^-1 J^T, then its factor
    rotational: NDArray[np.float64]  # (3, 3) J_r M^-1 J_r^T, then its factor
    acceleration: NDArray[np.float64]  # (N,) a
    wrench: NDArray[np.float64]  # (6,)
    null_wrench: NDArray[np.float64]  # (6,) Lambda J a


def control(joints: int) -> Control:
    """A controller at rest, of an arm with so many joints."""
    n = joints
    shapes = [n, 1, 3, (3, 3), n, (6, n), (n, n), (n, n), (n, 6), (6, 6), (3, 3), n, 6, 6]
    return Control(*(np.zeros(shape) for shape in shapes))
