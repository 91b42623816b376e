"""OSC_POSE's algebra against NumPy and MuJoCo on the formulas of `lfr.controllers.osc_pose`."""

import mujoco
import numpy as np
import pytest

from lfr.controllers import osc_pose
from lfr.robots import ROBOTS
from lfr.sim import kernel
from tests.controllers.arms import Dynamics, moving


@pytest.mark.parametrize("robot", ROBOTS)
def test_torques_follow_the_formulas(robot: str) -> None:
    engine = moving(robot)
    arrays, control, data = engine._scene.arrays, engine._control, engine._data
    action = np.array([0.3, -0.5, 0.2, 0.4, -0.1, 0.6, 1.0])
    osc_pose.set_goal(engine._physics, arrays, control, action)
    osc_pose.set_torques(engine._physics, arrays, control)

    arm = Dynamics.of(engine)
    J, M, q, dq = arm.jacobian, arm.mass, arm.q, arm.dq
    x, R = data.site_xpos[arrays.grip_site], data.site_xmat[arrays.grip_site].reshape(3, 3)
    quaternion, delta = np.zeros(4), np.zeros(9)
    rotation = action[3:6] * 0.5
    angle = np.linalg.norm(rotation)
    mujoco.mju_axisAngle2Quat(quaternion, rotation / angle, angle)
    mujoco.mju_quat2Mat(delta, quaternion)
    goal = delta.reshape(3, 3) @ R
    error = 0.5 * sum(np.cross(R[:, i], goal[:, i]) for i in range(3))
    inverse = np.linalg.inv(M)
    force = 150 * action[:3] * 0.05 - 2 * np.sqrt(150) * (J[:3] @ dq)
    torque = 150 * error - 2 * np.sqrt(150) * (J[3:] @ dq)
    wrench = np.concatenate(
        [
            np.linalg.pinv(J[:3] @ inverse @ J[:3].T) @ force,
            np.linalg.pinv(J[3:] @ inverse @ J[3:].T) @ torque,
        ]
    )
    null = np.eye(len(q)) - inverse @ J.T @ np.linalg.pinv(J @ inverse @ J.T) @ J
    posture = M @ (10 * (control.posture - q) - 2 * np.sqrt(10) * dq)
    expected = arm.clipped(J.T @ wrench + arm.bias + null.T @ posture)
    np.testing.assert_allclose(control.goal_position, x + action[:3] * 0.05, atol=1e-12)
    np.testing.assert_allclose(data.ctrl[: len(q)], expected, atol=1e-4)


def test_rotation_of_equals_robosuites() -> None:
    from robosuite.utils.transform_utils import axisangle2quat, quat2mat

    out = np.zeros((3, 3))
    for vector in [np.zeros(3), *np.random.default_rng(0).uniform(-0.5, 0.5, (200, 3))]:
        osc_pose.rotation_of(*vector, out)
        np.testing.assert_allclose(out, quat2mat(axisangle2quat(vector)), atol=2e-7)


@pytest.mark.parametrize("robot", ROBOTS)
def test_gripper_command_integrates_and_saturates(robot: str) -> None:
    engine = moving(robot)
    physics, arrays, control = engine._physics, engine._scene.arrays, engine._control
    control.gripper[0] = 0.0
    for command, expected in [(1, 0.2), (0.01, 0.4), (0, 0.4), (-1, 0.2)]:
        kernel._advance_gripper(physics, arrays, control, command)
        assert control.gripper[0] == pytest.approx(expected)
    for _ in range(9):
        kernel._advance_gripper(physics, arrays, control, 1.0)
    assert control.gripper[0] == 1.0
    ends = engine._model.actuator_ctrlrange[engine.joints :]
    closed = engine._data.ctrl[engine.joints :]
    assert all(np.isclose(value, end).any() for value, end in zip(closed, ends, strict=True))
