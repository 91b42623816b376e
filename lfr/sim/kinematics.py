"""An arm's kinematic model: where the hand is for any joint positions, and joints for a hand."""

from __future__ import annotations

import functools

import mujoco
import numpy as np
from numpy.typing import NDArray

from lfr.compiled.arrays import SceneArrays
from lfr.controllers.controller import Configuration
from lfr.controllers.joint_position import RETURN
from lfr.embodiments import embodiment
from lfr.sim.scene_cache import load_scene

STEPS, NEAR, DAMPING = 100, 1e-5, 1e-3
MOST = 0.3  # m and rad that a step may ask the hand to move


def jacobian(data: mujoco.MjData, arrays: SceneArrays, joints: int) -> NDArray[np.float64]:
    """Of the grip site by the arm's joints, translation above rotation, base frame, (6, N)."""
    base = data.xmat[arrays.base_body].reshape(3, 3)
    axes, anchors = data.xaxis[:joints], data.xanchor[:joints]  # of hinges in a chain
    hand = data.site_xpos[arrays.grip_site]
    return np.vstack([(np.cross(axes, hand - anchors) @ base).T, (axes @ base).T])


class Kinematics:
    """Forward and inverse kinematics of an embodiment's arm, from its model and nothing else.

    Raises:
        UnknownNameError: no such embodiment.
    """

    def __init__(self, name: str) -> None:
        scene = load_scene(name, "lift")  # any task: the arm is the same
        self.embodiment, self._scene = embodiment(name), scene
        self._data, self.joints = mujoco.MjData(scene.model), len(self.embodiment.robot.joints)
        self.rest = np.array(scene.start.joint_position)
        limits = scene.model.jnt_range[: self.joints]
        limited = scene.model.jnt_limited[: self.joints, None] > 0
        self._low, self._high = np.where(limited, limits, [-np.inf, np.inf]).T

    def at(self, joint_position: NDArray[np.float64]) -> Configuration:
        """The arm at joint positions (N,) rad."""
        self._move(joint_position)
        arrays = self._scene.arrays
        J = jacobian(self._data, arrays, self.joints)
        return Configuration(joint_position.copy(), self.rest, J, arrays.action_scale)

    def hand(
        self, joint_position: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Position (3,) m and rotation matrix (3, 3) of the grip site, in the base frame."""
        self._move(joint_position)
        data, arrays = self._data, self._scene.arrays
        base = data.xmat[arrays.base_body].reshape(3, 3)
        position = data.site_xpos[arrays.grip_site] - data.xpos[arrays.base_body]
        return position @ base, base.T @ data.site_xmat[arrays.grip_site].reshape(3, 3)

    def reach(
        self, position: NDArray[np.floating], rotation: NDArray[np.floating],
        start: NDArray[np.float64],
    ) -> NDArray[np.float64]:  # fmt: skip
        """Joint positions (N,) that bring the hand to a pose in the base frame, as near as it can.

        Damped least squares from ``start``; what the hand leaves free returns to the rest posture
        as under joint position control (`lfr.controllers.joint_position`).
        """
        q = start.copy()
        for _ in range(STEPS):
            here, turned = self.hand(q)
            error = np.concatenate([position - here, _rotation_vector(rotation @ turned.T)])
            if np.abs(error).max() < NEAR:
                break
            error *= min(1.0, MOST / float(np.abs(error).max()))
            J = jacobian(self._data, self._scene.arrays, self.joints)  # where `hand` has moved it
            inverse = J.T @ np.linalg.inv(J @ J.T + DAMPING**2 * np.eye(6))
            back = RETURN * (self.rest - q)
            back[0] = 0.0
            q = np.clip(q + inverse @ error + back - inverse @ (J @ back), self._low, self._high)
        return q

    def _move(self, joint_position: NDArray[np.float64]) -> None:
        self._data.qpos[: self.joints] = joint_position
        mujoco.mj_kinematics(self._scene.model, self._data)
        mujoco.mj_comPos(self._scene.model, self._data)


@functools.cache
def kinematics(name: str) -> Kinematics:
    """The kinematics of the embodiment called ``name``, kept for the next time."""
    return Kinematics(name)


def _rotation_vector(rotation: NDArray[np.floating]) -> NDArray[np.float64]:
    quaternion, vector = np.empty(4), np.empty(3)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation, dtype=np.float64).ravel())
    mujoco.mju_quat2Vel(vector, quaternion, 1.0)
    return vector
