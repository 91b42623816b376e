"""The controller's algebra against NumPy and MuJoCo on the formulas of `lfr.sim.osc`."""

import mujoco
import numpy as np
import pytest

from lfr.robots import ROBOTS
from lfr.sim import osc
from lfr.sim.simulation import simulation


@pytest.fixture(params=list(ROBOTS))
def engine(request: pytest.FixtureRequest):
    engine = simulation(request.param, "lift")
    engine.reset(1)
    engine.step(np.random.default_rng(2).uniform(-1, 1, (6, 7)) * [1, 1, 0, 1, 1, 1, 1])
    mujoco.mj_step1(engine._model, engine._data)
    return engine


def test_torques_follow_the_formulas(engine) -> None:
    model, data, control = engine._model, engine._data, engine._control
    arrays, site = engine._scene.arrays, engine._scene.arrays.grip_site
    action = np.array([0.3, -0.5, 0.2, 0.4, -0.1, 0.6, 1.0])
    osc.set_goal(engine._physics, arrays, control, action)
    osc.set_torques(engine._physics, arrays, control)

    jacobian = np.zeros((6, model.nv))
    mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], site)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, full, data.qM)
    J, M, q, dq = jacobian[:, :7], full[:7, :7], data.qpos[:7], data.qvel[:7]
    x, R = data.site_xpos[site], data.site_xmat[site].reshape(3, 3)
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
    null = np.eye(7) - inverse @ J.T @ np.linalg.pinv(J @ inverse @ J.T) @ J
    posture = M @ (10 * (control.posture - q) - 2 * np.sqrt(10) * dq)
    expected = J.T @ wrench + data.qfrc_bias[:7] + null.T @ posture
    limits = model.actuator_ctrlrange[:7]
    np.testing.assert_allclose(control.goal_position, x + action[:3] * 0.05, atol=1e-12)
    np.testing.assert_allclose(
        data.ctrl[:7], np.clip(expected, limits[:, 0], limits[:, 1]), atol=1e-4
    )


def test_rotation_of_equals_robosuites() -> None:
    from robosuite.utils.transform_utils import axisangle2quat, quat2mat

    out = np.zeros((3, 3))
    for vector in [np.zeros(3), *np.random.default_rng(0).uniform(-0.5, 0.5, (200, 3))]:
        osc.rotation_of(*vector, out)
        np.testing.assert_allclose(out, quat2mat(axisangle2quat(vector)), atol=2e-7)


def test_gripper_command_integrates_and_saturates(engine) -> None:
    control = engine._control
    control.gripper[0] = 0.0
    for command, expected in [(1, 0.2), (0.01, 0.4), (0, 0.4), (-1, 0.2)]:
        osc.advance_gripper(engine._physics, engine._scene.arrays, control, command)
        assert control.gripper[0] == pytest.approx(expected)
    for _ in range(9):
        osc.advance_gripper(engine._physics, engine._scene.arrays, control, 1.0)
    assert control.gripper[0] == 1.0
    ends = engine._model.actuator_ctrlrange[7:]
    assert all(np.isclose(engine._data.ctrl[7 + i], ends[i]).any() for i in range(2))
