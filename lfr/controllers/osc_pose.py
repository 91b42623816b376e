"""Operational space control, as robosuite's OSC_POSE computes it, compiled.

O. Khatib, "A unified approach for motion and force control of robot manipulators" (1987), with the
position and orientation parts decoupled and a joint-space spring in the null space:

    Lambda   = (J M^-1 J^T)^-1,  Lambda_p = (J_p M^-1 J_p^T)^-1,  Lambda_r = (J_r M^-1 J_r^T)^-1
    F        = kp (x_d - x) - kd x_dot              tau = kp e(R_d, R) - kd omega
    Gamma    = J^T [Lambda_p F; Lambda_r tau] + b + N^T M a
    a        = 10 (q_0 - q) - 2 sqrt(10) q_dot,     N^T M a = M a - J^T Lambda J a

with b gravity, Coriolis and centrifugal forces. Source: robosuite 1.5.2,
`controllers/parts/arm/osc.py` and `utils/control_utils.py`. robosuite inverts with `pinv`; the
matrices are positive definite, so a Cholesky factor gives the same to rounding, 50 times faster.
"""

import math

import numpy as np
from numpy.typing import NDArray

from lfr.compiled import compiled
from lfr.compiled.arrays import Control, Physics, SceneArrays
from lfr.compiled.linear import factorise, solve
from lfr.controllers.controller import (
    ROTATION_UNIT,
    TRANSLATION_UNIT,
    Configuration,
    Controller,
)
from lfr.controllers.inertia import inertia
from lfr.robots.robot import Robot
from lfr.spaces import Quantity, translation, turn

KP = 150.0
KD = 2.0 * math.sqrt(KP)  # damping ratio 1
POSTURE_KP = 10.0
POSTURE_KD = 2.0 * math.sqrt(POSTURE_KP)


@compiled
def rotation_of(rx: float, ry: float, rz: float, out: NDArray[np.float64]) -> None:
    """Rotation matrix of a rotation vector (rad).

    robosuite's `quat2mat` rounds the quaternion to float32; so does this.
    """
    angle = math.sqrt(rx * rx + ry * ry + rz * rz)
    scale = math.sin(angle / 2.0) / angle if angle > 0.0 else 0.0
    w, x = np.float32(math.cos(angle / 2.0)), np.float32(rx * scale)
    y, z = np.float32(ry * scale), np.float32(rz * scale)
    norm = math.sqrt(2.0 / np.float32(w * w + x * x + y * y + z * z))
    w, x = np.float32(w * norm), np.float32(x * norm)
    y, z = np.float32(y * norm), np.float32(z * norm)
    out[0, 0], out[0, 1], out[0, 2] = 1.0 - y * y - z * z, x * y - z * w, x * z + y * w
    out[1, 0], out[1, 1], out[1, 2] = x * y + z * w, 1.0 - x * x - z * z, y * z - x * w
    out[2, 0], out[2, 1], out[2, 2] = x * z - y * w, y * z + x * w, 1.0 - x * x - y * y


@compiled
def set_goal(
    physics: Physics, scene: SceneArrays, control: Control, action: NDArray[np.float64]
) -> None:
    """Goal pose from an action's deltas in the base frame, relative to the pose achieved."""
    position, rotation = physics.site_xpos[scene.grip_site], physics.site_xmat[scene.grip_site]
    base = physics.site_xmat[scene.controller_site]
    delta = control.rotational  # (3, 3), free until the next torque
    clipped = control.wrench
    for i in range(6):
        clipped[i] = min(max(action[i], -1.0), 1.0) * scene.action_scale[i]
    rotation_of(clipped[3], clipped[4], clipped[5], delta)
    for i in range(3):
        control.goal_position[i] = position[i]
        for k in range(3):
            control.goal_position[i] += base[3 * i + k] * clipped[k]
    # R_d = B dR B^T R with B the base's axes
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                for m in range(3):
                    for n in range(3):
                        turned = base[3 * n + m] * rotation[3 * n + j]
                        total += base[3 * i + k] * delta[k, m] * turned
            control.goal_rotation[i, j] = total


@compiled
def set_torques(physics: Physics, scene: SceneArrays, control: Control) -> None:
    """Torques of the arm (N m) for the current state and goal, clipped to the actuators' limits."""
    _jacobian(physics, scene, control)
    _operational_inertia(physics, scene, control)
    _wrench(physics, scene, control)
    J, M, a = control.jacobian, control.mass, control.acceleration
    joints = a.shape[0]
    for j in range(joints):
        a[j] = POSTURE_KP * (control.posture[j] - physics.qpos[j]) - POSTURE_KD * physics.qvel[j]
    for i in range(6):
        control.null_wrench[i] = 0.0
        for j in range(joints):
            control.null_wrench[i] += J[i, j] * a[j]
    # The leading block of the factor of J M^-1 J^T is the factor of J_p M^-1 J_p^T.
    solve(control.operational, 6, control.null_wrench, 0)
    solve(control.operational, 3, control.wrench, 0)
    solve(control.rotational, 3, control.wrench, 3)
    for j in range(joints):
        torque = physics.bias[j]
        for i in range(6):
            torque += J[i, j] * (control.wrench[i] - control.null_wrench[i])
        for k in range(joints):
            torque += M[j, k] * a[k]
        physics.ctrl[j] = min(max(torque, scene.ctrl_range[j, 0]), scene.ctrl_range[j, 1])


@compiled
def _jacobian(physics: Physics, scene: SceneArrays, control: Control) -> None:
    position, J = physics.site_xpos[scene.grip_site], control.jacobian
    for j in range(J.shape[1]):  # hinge joints in a chain: a x (p - anchor), a
        ax, ay, az = physics.xaxis[j, 0], physics.xaxis[j, 1], physics.xaxis[j, 2]
        rx = position[0] - physics.xanchor[j, 0]
        ry = position[1] - physics.xanchor[j, 1]
        rz = position[2] - physics.xanchor[j, 2]
        J[0, j], J[1, j], J[2, j] = ay * rz - az * ry, az * rx - ax * rz, ax * ry - ay * rx
        J[3, j], J[4, j], J[5, j] = ax, ay, az


@compiled
def _operational_inertia(physics: Physics, scene: SceneArrays, control: Control) -> None:
    L, J, Y = control.factor, control.jacobian, control.half
    joints = inertia(physics, scene, control)
    for i in range(joints):
        for j in range(i + 1):
            L[i, j] = control.mass[i, j]
    factorise(L, joints)
    for c in range(6):
        for i in range(joints):
            total = J[c, i]
            for k in range(i):
                total -= L[i, k] * Y[k, c]
            Y[i, c] = total / L[i, i]
    for i in range(6):
        for j in range(i + 1):
            total = 0.0
            for k in range(joints):
                total += Y[k, i] * Y[k, j]
            control.operational[i, j] = total
            if j >= 3:
                control.rotational[i - 3, j - 3] = total
    factorise(control.operational, 6)
    factorise(control.rotational, 3)


@compiled
def _wrench(physics: Physics, scene: SceneArrays, control: Control) -> None:
    position, R = physics.site_xpos[scene.grip_site], physics.site_xmat[scene.grip_site]
    D, J, w = control.goal_rotation, control.jacobian, control.wrench
    joints = J.shape[1]
    for i in range(3):
        w[i] = KP * (control.goal_position[i] - position[i])
        # orientation error: half the sum of the columns' cross products, R_c x D_c
        j, k = (i + 1) % 3, (i + 2) % 3
        error = 0.0
        for c in range(3):
            error += R[3 * j + c] * D[k, c] - R[3 * k + c] * D[j, c]
        w[3 + i] = KP * 0.5 * error
    for i in range(6):
        velocity = 0.0
        for j in range(joints):
            velocity += J[i, j] * physics.qvel[j]
        w[i] -= KD * velocity


def _motion(robot: Robot) -> tuple[Quantity, ...]:
    return translation((TRANSLATION_UNIT,) * 3), turn((ROTATION_UNIT,) * 3)


def _action_of(motion: NDArray[np.float64], at: Configuration) -> NDArray[np.float64]:
    return motion


OSC_POSE = Controller(
    name="osc_pose",
    stock_name="OSC_POSE",
    motion=_motion,
    set_goal=set_goal,
    set_torques=set_torques,
    action_of=_action_of,
    stock_gains={
        "kp": KP,
        "damping_ratio": 1,
        "impedance_mode": "fixed",
        "kp_limits": [0, 300],
        "damping_ratio_limits": [0, 10],
        "position_limits": None,
        "orientation_limits": None,
        "uncouple_pos_ori": True,
        "input_ref_frame": "base",
        "ramp_ratio": 0.2,
    },
)
