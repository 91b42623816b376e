"""Operational space control, as robosuite's OSC_POSE computes it, for the compiled kernel.

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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lfr.sim.compilation import compiled
from lfr.sim.libmujoco import Physics
from lfr.sim.scene import SceneArrays

JOINTS = 7
KP = 150.0
KD = 2.0 * math.sqrt(KP)  # damping ratio 1
POSTURE_KP = 10.0
POSTURE_KD = 2.0 * math.sqrt(POSTURE_KP)
POSITION_SCALE = 0.05  # m per unit of action
ROTATION_SCALE = 0.5  # rad per unit of action


class Controller(NamedTuple):
    """What the controller remembers, and room to compute in."""

    posture: NDArray[np.float64]  # (7,) q_0, target of the null-space spring
    gripper: NDArray[np.float64]  # (1,) integrated command in [-1, 1], +1 closed
    goal_position: NDArray[np.float64]  # (3,) x_d, world frame
    goal_rotation: NDArray[np.float64]  # (3, 3) R_d, world frame
    jacobian: NDArray[np.float64]  # (6, 7) of the grip site
    mass: NDArray[np.float64]  # (7, 7) M
    factor: NDArray[np.float64]  # (7, 7) lower Cholesky factor of M
    half: NDArray[np.float64]  # (7, 6) factor^-1 J^T, so that J M^-1 J^T = half^T half
    operational: NDArray[np.float64]  # (6, 6) J M^-1 J^T, then its factor
    rotational: NDArray[np.float64]  # (3, 3) J_r M^-1 J_r^T, then its factor
    acceleration: NDArray[np.float64]  # (7,) a
    wrench: NDArray[np.float64]  # (6,)
    null_wrench: NDArray[np.float64]  # (6,) Lambda J a


def controller() -> Controller:
    """A controller at rest."""
    shapes = [7, 1, 3, (3, 3), (6, 7), (7, 7), (7, 7), (7, 6), (6, 6), (3, 3), 7, 6, 6]
    return Controller(*(np.zeros(shape) for shape in shapes))


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
    physics: Physics, scene: SceneArrays, control: Controller, action: NDArray[np.float64]
) -> None:
    """Goal pose from an action's deltas in the base frame, relative to the pose achieved."""
    position, rotation = physics.site_xpos[scene.grip_site], physics.site_xmat[scene.grip_site]
    base = physics.site_xmat[scene.controller_site]
    delta = control.rotational  # (3, 3), free until the next torque
    clipped = control.wrench
    for i in range(6):
        scale = POSITION_SCALE if i < 3 else ROTATION_SCALE
        clipped[i] = min(max(action[i], -1.0), 1.0) * scale
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
def advance_gripper(
    physics: Physics, scene: SceneArrays, control: Controller, command: float
) -> None:
    """Integrate the gripper's command by 0.2 towards its sign and set both actuators."""
    step = 0.2 if command > 0.0 else (-0.2 if command < 0.0 else 0.0)
    control.gripper[0] = min(max(control.gripper[0] + step, -1.0), 1.0)
    for i in range(2):
        low, high = scene.ctrl_range[JOINTS + i, 0], scene.ctrl_range[JOINTS + i, 1]
        target = scene.close_signs[i] * control.gripper[0]
        physics.ctrl[JOINTS + i] = 0.5 * (high + low) + 0.5 * (high - low) * target


@compiled
def set_torques(physics: Physics, scene: SceneArrays, control: Controller) -> None:
    """Torques of the arm (N m) for the current state and goal, clipped to the actuators' limits."""
    _jacobian(physics, scene, control)
    _operational_inertia(physics, scene, control)
    _wrench(physics, scene, control)
    J, M, a = control.jacobian, control.mass, control.acceleration
    for j in range(JOINTS):
        a[j] = POSTURE_KP * (control.posture[j] - physics.qpos[j]) - POSTURE_KD * physics.qvel[j]
    for i in range(6):
        control.null_wrench[i] = 0.0
        for j in range(JOINTS):
            control.null_wrench[i] += J[i, j] * a[j]
    # The leading block of the factor of J M^-1 J^T is the factor of J_p M^-1 J_p^T.
    _solve(control.operational, 6, control.null_wrench, 0)
    _solve(control.operational, 3, control.wrench, 0)
    _solve(control.rotational, 3, control.wrench, 3)
    for j in range(JOINTS):
        torque = physics.bias[j]
        for i in range(6):
            torque += J[i, j] * (control.wrench[i] - control.null_wrench[i])
        for k in range(JOINTS):
            torque += M[j, k] * a[k]
        physics.ctrl[j] = min(max(torque, scene.ctrl_range[j, 0]), scene.ctrl_range[j, 1])


@compiled
def _jacobian(physics: Physics, scene: SceneArrays, control: Controller) -> None:
    position, J = physics.site_xpos[scene.grip_site], control.jacobian
    for j in range(JOINTS):  # hinge joints in a chain: a x (p - anchor), a
        ax, ay, az = physics.xaxis[j, 0], physics.xaxis[j, 1], physics.xaxis[j, 2]
        rx = position[0] - physics.xanchor[j, 0]
        ry = position[1] - physics.xanchor[j, 1]
        rz = position[2] - physics.xanchor[j, 2]
        J[0, j], J[1, j], J[2, j] = ay * rz - az * ry, az * rx - ax * rz, ax * ry - ay * rx
        J[3, j], J[4, j], J[5, j] = ax, ay, az


@compiled
def _operational_inertia(physics: Physics, scene: SceneArrays, control: Controller) -> None:
    M, L, J, Y = control.mass, control.factor, control.jacobian, control.half
    for i in range(JOINTS):
        for j in range(i + 1):
            value = physics.inertia[scene.inertia_index[i, j]]
            M[i, j] = M[j, i] = L[i, j] = value
    _factorise(L, JOINTS)
    for c in range(6):
        for i in range(JOINTS):
            total = J[c, i]
            for k in range(i):
                total -= L[i, k] * Y[k, c]
            Y[i, c] = total / L[i, i]
    for i in range(6):
        for j in range(i + 1):
            total = 0.0
            for k in range(JOINTS):
                total += Y[k, i] * Y[k, j]
            control.operational[i, j] = total
            if j >= 3:
                control.rotational[i - 3, j - 3] = total
    _factorise(control.operational, 6)
    _factorise(control.rotational, 3)


@compiled
def _wrench(physics: Physics, scene: SceneArrays, control: Controller) -> None:
    position, R = physics.site_xpos[scene.grip_site], physics.site_xmat[scene.grip_site]
    D, J, w = control.goal_rotation, control.jacobian, control.wrench
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
        for j in range(JOINTS):
            velocity += J[i, j] * physics.qvel[j]
        w[i] -= KD * velocity


@compiled
def _factorise(A: NDArray[np.float64], n: int) -> None:
    """Lower Cholesky factor in place; a direction without inertia gets no force (as by pinv)."""
    for i in range(n):
        for j in range(i + 1):
            total = A[i, j]
            for k in range(j):
                total -= A[i, k] * A[j, k]
            if i == j:
                A[i, i] = math.sqrt(total) if total > 1e-14 else 1e30
            else:
                A[i, j] = total / A[j, j]


@compiled
def _solve(L: NDArray[np.float64], n: int, x: NDArray[np.float64], offset: int) -> None:
    """x[offset:offset+n] <- (L L^T)^-1 x."""
    for i in range(n):
        total = x[offset + i]
        for k in range(i):
            total -= L[i, k] * x[offset + k]
        x[offset + i] = total / L[i, i]
    for i in range(n - 1, -1, -1):
        total = x[offset + i]
        for k in range(i + 1, n):
            total -= L[k, i] * x[offset + k]
        x[offset + i] = total / L[i, i]
