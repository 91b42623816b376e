"""Joint position control: torques by closed form, and the hand motions that its labels give."""

import numpy as np
import pytest

from lfr.controllers import joint_position
from lfr.controllers.controller import ROTATION_UNIT, TRANSLATION_UNIT, Configuration
from lfr.embodiments import embodiment
from lfr.robots import ROBOTS
from lfr.sim.simulation import simulation
from tests.controllers.arms import Dynamics, moving

NAMES = [f"{robot}-joint_position" for robot in ROBOTS]


@pytest.mark.parametrize("name", NAMES)
def test_torques_follow_the_formula(name: str) -> None:
    engine = moving(name)
    arrays, control = engine._scene.arrays, engine._control
    action = np.random.default_rng(3).uniform(-1.5, 1.5, engine.action_size)
    joint_position.set_goal(engine._physics, arrays, control, action)
    joint_position.set_torques(engine._physics, arrays, control)
    arm = Dynamics.of(engine)
    goal = arm.q + np.clip(action[:-1], -1, 1) * engine.embodiment.action_scale
    wanted = 150 * (goal - arm.q) - 2 * np.sqrt(150) * arm.dq
    np.testing.assert_allclose(control.goal_joints, goal, atol=1e-12)
    expected = arm.clipped(arm.mass @ wanted + arm.bias)
    np.testing.assert_allclose(engine._data.ctrl[: len(goal)], expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_a_label_moves_the_hand_the_way_that_was_wanted(name: str) -> None:
    """To first order, by the arm's own Jacobian, which MuJoCo gives independently."""
    engine = moving(name)
    at, arm = engine.configuration(), Dynamics.of(engine)
    for direction in np.eye(6):
        motion = 0.1 * direction
        delta = joint_position.action_of(motion, at) * at.scale
        done = arm.jacobian @ delta / np.repeat([TRANSLATION_UNIT, ROTATION_UNIT], 3)
        assert done @ direction > 0.05
        np.testing.assert_allclose(done, motion, atol=0.05)


def test_a_joint_that_saturates_slows_all_and_keeps_the_direction() -> None:
    engine = moving("panda-joint_position")
    at = engine.configuration()
    at = Configuration(at.rest, at.rest, at.jacobian, at.scale)  # nothing to come back to
    slow, fast = (joint_position.action_of(k * np.ones(6), at) for k in (0.1, 10.0))
    assert np.abs(fast).max() == pytest.approx(1.0)
    np.testing.assert_allclose(fast / np.linalg.norm(fast), slow / np.linalg.norm(slow))


def test_the_posture_comes_back_without_moving_the_hand() -> None:
    engine = moving("panda-joint_position")
    arm, at = Dynamics.of(engine), engine.configuration()
    bent = Configuration(at.joint_position, at.joint_position + 0.2, at.jacobian, at.scale)
    delta = joint_position.action_of(np.zeros(6), bent) * at.scale
    assert np.linalg.norm(delta[1:]) > 0.005
    assert np.linalg.norm(arm.jacobian @ delta) < 0.1 * np.linalg.norm(delta)


@pytest.mark.parametrize("robot", ROBOTS)
def test_an_action_of_one_moves_the_hand_equally_whichever_joint_it_is(robot: str) -> None:
    """45 mm, turns counted at 0.1 m, over postures about the one that the arm starts from."""
    engine, effects = simulation(f"{robot}-joint_position", "lift"), []
    rng = np.random.default_rng(0)
    for seed in range(200):
        engine.reset(seed)
        near = rng.normal(engine._scene.start.joint_position, 0.25)
        engine._data.qpos[: engine.joints] = near
        engine.observation()
        J = engine.configuration().jacobian
        effects.append(np.hypot(*(np.linalg.norm(part, axis=0) for part in (J[:3], 0.1 * J[3:]))))
    effect = np.sqrt(np.mean(np.square(effects), axis=0))  # (N,) m per rad
    expected = np.minimum(0.045 / effect, 0.4)
    np.testing.assert_allclose(engine.embodiment.action_scale, expected, atol=0.01)


@pytest.mark.parametrize("robot", ROBOTS)
def test_the_first_joint_is_vertical(robot: str) -> None:
    """What `lfr.skills.symmetry.suited` takes for granted of every arm here."""
    engine = simulation(robot, "lift")
    engine.reset(0)
    np.testing.assert_allclose(np.abs(engine.configuration().jacobian[3:, 0]), [0, 0, 1], atol=1e-5)


def test_an_action_has_a_dimension_for_every_joint_and_the_gripper() -> None:
    assert embodiment("ur5e-joint_position").action.size == 7
    assert embodiment("iiwa-joint_position").action.names[0] == "dq.joint_1"
