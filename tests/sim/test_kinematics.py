"""Kinematics from the model alone, held to the simulation and to finite differences."""

import numpy as np
import pytest

from lfr.seeds import episode_seed
from lfr.sim.kinematics import kinematics
from lfr.sim.simulation import simulation
from lfr.spaces import ROBOT_STATE

ARMS = ("panda", "sawyer-joint_position", "ur5e-joint_position", "jaco")


def postures(arm: str, task: str, count: int = 6):
    """The simulation of an arm, in postures that it moves to."""
    running = simulation(arm, task)
    rng = np.random.default_rng(0)
    for index in range(count):
        running.reset(episode_seed("learning", index))
        motion = rng.uniform(-0.6, 0.6, running.action_size)
        running.step(np.tile(motion, (12, 1)))
        yield running


@pytest.mark.parametrize("arm", ARMS)
def test_where_the_hand_is_and_how_it_moves(arm: str) -> None:
    """In another task's scene, whose base may stand elsewhere."""
    model = kinematics(arm)
    for running in postures(arm, "pick_place"):
        here, wanted = model.at(running.joint_position()), running.configuration()
        np.testing.assert_allclose(here.jacobian, wanted.jacobian, atol=1e-9)
        np.testing.assert_array_equal(here.scale, wanted.scale)
        position, rotation = model.hand(running.joint_position())
        seen = running.observation()[: ROBOT_STATE.size]
        np.testing.assert_allclose(position, seen[ROBOT_STATE.slice("eef_pos")], atol=1e-9)
        columns = rotation[:, :2].T.ravel()
        np.testing.assert_allclose(columns, seen[ROBOT_STATE.slice("eef_rot6d")], atol=1e-9)


@pytest.mark.parametrize("arm", ARMS)
def test_the_jacobian_is_the_slope_of_the_hand(arm: str) -> None:
    model = kinematics(arm)
    q, small = model.rest + 0.1, 1e-6
    J = model.at(q).jacobian
    for joint in range(model.joints):
        step = small * np.eye(model.joints)[joint]
        (after, turned), (before, unturned) = model.hand(q + step), model.hand(q - step)
        np.testing.assert_allclose((after - before) / (2 * small), J[:3, joint], atol=1e-6)
        spin = (turned @ unturned.T - unturned @ turned.T) / (4 * small)
        np.testing.assert_allclose([spin[2, 1], spin[0, 2], spin[1, 0]], J[3:, joint], atol=1e-6)


@pytest.mark.parametrize("arm", ARMS)
def test_the_hand_is_brought_where_it_was(arm: str) -> None:
    model = kinematics(arm)
    for running in postures(arm, "lift"):
        position, rotation = model.hand(running.joint_position())
        found = model.reach(position, rotation, model.rest)
        here, turned = model.hand(found)
        np.testing.assert_allclose(here, position, atol=1e-4)
        np.testing.assert_allclose(turned, rotation, atol=1e-3)
