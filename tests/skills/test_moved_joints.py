"""Joint motions of a moved scene, against an arm whose kinematics are known in closed form."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from lfr.skills.condition import POSE_NAMES
from lfr.skills.hand_motion import HandJacobian, hand_motion
from lfr.skills.moved_joints import move_joint_motions, moved_joint_copies
from lfr.skills.normalizer import azimuth
from lfr.skills.symmetry import SceneMotion, SymmetryParams, move

NAMES = (*POSE_NAMES, "cube_pos.x", "cube_pos.y", "cube_pos.z", "eef_to_cube.x", "eef_to_cube.y",
         "eef_to_cube.z")  # fmt: skip


class Gantry(HandJacobian):
    """Seven joints: three slide along base axes, three turn about them, one does nothing."""

    def __init__(self) -> None:
        super().__init__(7, 4)

    def forward(self, observations: Tensor) -> Tensor:
        cos, sin = azimuth(observations).unbind(-1)
        zero, one = torch.zeros_like(cos), torch.ones_like(cos)
        rows = [(cos, sin, zero), (-sin, cos, zero), (zero, zero, one)]
        to_azimuth = torch.stack([torch.stack(row, -1) for row in rows], -2)  # (B, 3, 3)
        J = torch.zeros(len(observations), 6, 7)
        J[:, :3, :3] = to_azimuth
        J[:, 3:, 3:6] = 0.5 * to_azimuth
        return J


def windows(count: int = 32) -> tuple[Tensor, Tensor]:
    generator = torch.Generator().manual_seed(0)
    observations = torch.rand(count, len(NAMES), generator=generator) * 0.4 + 0.2
    observations[:, 3:9] = torch.tensor([1.0, 0, 0, 0, -1.0, 0])
    observations[:, 12:] = observations[:, 9:12] - observations[:, :3]
    return observations, torch.rand(count, 10, 8, generator=generator) - 0.5


@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_the_hand_moves_as_the_scene_does(mirror: float) -> None:
    observations, actions = windows()
    count, gantry = len(observations), Gantry()
    motion = SceneMotion(torch.zeros(count), torch.full((count,), mirror), torch.rand(count, 3) / 5)
    moved = move(observations, NAMES, motion)
    found = move_joint_motions(actions, observations, moved, motion, gantry)
    # The sliders are along the base's axes: a shift changes nothing, a mirror image is closed form.
    expected = actions.clone()
    if mirror < 0:
        expected[..., [1, 3, 5]] *= -1.0  # y of a vector, x and z of an axial one
        expected[..., 6] = 0.0
    torch.testing.assert_close(found, expected, atol=5e-3, rtol=0)
    assert torch.equal(found[..., -1], actions[..., -1])


def test_what_the_hand_leaves_free_stays_as_it_was() -> None:
    observations, actions = windows()
    still = SceneMotion(torch.zeros(32), torch.ones(32), torch.full((32, 3), 0.1))
    found = move_joint_motions(
        actions, observations, move(observations, NAMES, still), still, Gantry()
    )
    torch.testing.assert_close(found[..., 6], actions[..., 6], atol=1e-5, rtol=0)


def test_copies_come_after_the_windows_and_move_alike() -> None:
    observations, actions = windows()
    params = SymmetryParams(copies=3, shift=0.2, mirror=True)
    generator = torch.Generator().manual_seed(1)
    seen, done = moved_joint_copies(observations, actions, NAMES, params, Gantry(), generator)
    assert (len(seen), len(done)) == (4 * 32, 4 * 32)
    assert torch.equal(seen[:32], observations)
    assert torch.equal(done[:32], actions)
    # offsets are those of the positions, and no copy is turned
    torch.testing.assert_close(seen[:, 12:], seen[:, 9:12] - seen[:, :3])
    assert (seen[:, 12] - seen[:, 12].view(4, 32)[0].repeat(4)).abs().max() < 1e-6
    # the hand's speed is kept
    gantry = Gantry()
    speeds = [hand_motion(a, o, gantry(o))[..., :3].norm(dim=-1) for o, a in
              ((seen[:32], done[:32]), (seen[32:64], done[32:64]))]  # fmt: skip
    torch.testing.assert_close(speeds[0], speeds[1], atol=5e-3, rtol=0)


def test_without_copies_nothing_is_drawn() -> None:
    observations, actions = windows()
    params = SymmetryParams(copies=0)
    generator = torch.Generator().manual_seed(1)
    before = generator.get_state()
    seen, _ = moved_joint_copies(observations, actions, NAMES, params, Gantry(), generator)
    assert seen is observations
    assert torch.equal(generator.get_state(), before)
    assert math.isclose(float(azimuth(observations).norm(dim=-1).mean()), 1.0, rel_tol=1e-5)
