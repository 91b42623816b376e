"""The Jacobian learned from demonstrations against the arm's own model."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from lfr.columns import ActionSpace
from lfr.controllers.controller import HAND_UNITS
from lfr.data.windows import DemonstrationSet
from lfr.embodiments import embodiment
from lfr.sim.kinematics import kinematics
from lfr.skills.condition import POSE_NAMES
from lfr.skills.hand_motion import (
    HandJacobian,
    JacobianParams,
    hand_motion,
    hand_steps,
    jacobian_error,
    train_jacobian,
)
from lfr.skills.symmetry import SceneMotion, move


def wandering(robot: str, episodes: int, seed: int) -> DemonstrationSet:
    """An arm whose joints wander about its rest posture, as its own kinematic model sees it."""
    arm, rng = kinematics(robot), np.random.default_rng(seed)
    length, states, joints = 40, [], []
    for _ in range(episodes):
        q = arm.rest + rng.uniform(-0.25, 0.25, arm.joints)
        for _ in range(length):
            position, rotation = arm.hand(q)
            states.append([*position, *rotation[:, 0], *rotation[:, 1]])
            joints.append(q.copy())
            q = q + rng.uniform(-0.03, 0.03, arm.joints)
    names = embodiment(robot).action.names
    count = episodes * length
    return DemonstrationSet(
        torch.tensor(np.array(states), dtype=torch.float32),
        torch.zeros(count, len(names)), None, None, torch.arange(episodes + 1) * length,
        POSE_NAMES, ActionSpace(names, (-1.0,) * len(names), (1.0,) * len(names)), robot, "", 20,
        joint_positions=torch.tensor(np.array(joints), dtype=torch.float32),
    )  # fmt: skip


@pytest.mark.parametrize("robot", ["panda-joint_position", "ur5e-joint_position"])
def test_it_is_the_arms_own(robot: str) -> None:
    steps, held_out = (hand_steps(wandering(robot, n, seed)) for n, seed in ((60, 0), (5, 1)))
    assert steps is not None
    assert held_out is not None
    scale, params = embodiment(robot).action_scale, JacobianParams(hidden=64, steps=1500)
    jacobian = train_jacobian(steps, scale, params, seed=0)
    assert jacobian_error(jacobian, held_out) < 0.15
    untrained = train_jacobian(steps, scale, JacobianParams(hidden=64, steps=0), seed=0)
    assert jacobian_error(untrained, held_out) > 0.8

    arm = kinematics(robot)
    position, rotation = arm.hand(arm.rest)
    seen = torch.tensor([[*position, *rotation[:, 0], *rotation[:, 1]]], dtype=torch.float32)
    azimuth = np.arctan2(position[1], position[0])
    back = np.array([[np.cos(azimuth), np.sin(azimuth), 0],
                     [-np.sin(azimuth), np.cos(azimuth), 0], [0, 0, 1]])  # fmt: skip
    own = arm.at(arm.rest).jacobian * np.array(scale)
    own = np.vstack([back @ own[:3], back @ own[3:]]) / HAND_UNITS[:, None]
    found = jacobian(seen)[0].detach().numpy()
    assert np.linalg.norm(found - own) < 0.15 * np.linalg.norm(own)


def test_steps_stay_within_an_episode_and_in_the_frame_of_the_azimuth() -> None:
    one = wandering("panda-joint_position", 2, 0)
    steps = hand_steps(one)
    assert steps is not None
    assert len(steps.poses) == len(one) - 2
    assert steps.joints.abs().max() < 0.031  # none from one episode to the next
    # the whole arm turned about its vertical: other poses, the same steps
    count = len(one)
    motion = SceneMotion(torch.full((count,), 0.6), torch.ones(count), torch.zeros(count, 3), True)
    turned = hand_steps(replace(one, observations=move(one.observations, POSE_NAMES, motion)))
    assert turned is not None
    torch.testing.assert_close(turned.hand, steps.hand, atol=2e-4, rtol=1e-3)
    assert not torch.allclose(turned.poses, steps.poses, atol=0.05)


def test_there_are_none_where_the_joints_are_not_recorded() -> None:
    one = wandering("panda-joint_position", 1, 0)
    assert hand_steps(replace(one, joint_positions=None)) is None


def test_a_cartesian_action_is_the_hands_motion_turned() -> None:
    seen = torch.tensor([[0.0, 0.5, 0.2, 1, 0, 0, 0, -1, 0]])  # the hand is over the y axis
    action = torch.tensor([[[0.3, 0.1, 0.2, 0.4, -0.5, 0.6, 1.0]]])
    expected = torch.tensor([[[0.1, -0.3, 0.2, -0.5, -0.4, 0.6, 1.0]]])
    torch.testing.assert_close(hand_motion(action, seen), expected)


def test_a_joint_action_moves_the_hand_by_the_jacobian() -> None:
    torch.manual_seed(0)
    jacobian, seen = HandJacobian(6, 8), torch.randn(3, 9)
    jacobian.scale.copy_(torch.arange(1.0, 7.0))
    actions = torch.randn(3, 4, 7)
    moved = hand_motion(actions, seen, jacobian(seen))
    for b in range(3):
        J = jacobian.by_joints(seen[b : b + 1])[0]
        for t in range(4):
            expected = J @ (actions[b, t, :6] * jacobian.scale)
            torch.testing.assert_close(moved[b, t, :6], expected, rtol=1e-4, atol=1e-5)
            assert moved[b, t, 6] == actions[b, t, 6]
