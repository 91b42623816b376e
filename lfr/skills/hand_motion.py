"""What an arm's joint motions do to its hand, learned from its own demonstrations.

Where actions are motions of an arm's joints, two arms do the same where their hands move alike. How
far its joints move an arm's hand stands in what it was shown: from one row to the next both are
recorded. The Jacobian that is learned from these needs no kinematic model; at it the skill VAE's
error counts (`lfr.skills.vae.action_error`), and by it two arms' skills are compared
(`lfr.mapping.hand_loss`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor, nn

from lfr.controllers.controller import HAND_UNITS
from lfr.data.windows import DemonstrationSet
from lfr.networks.optimizer import FlatAdam, annealed, clip_norm, flatten_parameters, trainable
from lfr.skills.condition import POSE_NAMES, Conditioned
from lfr.skills.normalizer import azimuth
from lfr.skills.rows import thinned

MOST_NORM = 100.0  # of the gradient
TYPICAL = 0.1
"""Motion of a hand in a control step, in its units: what counts as 1 in the loss."""

_UNITS = torch.tensor(HAND_UNITS, dtype=torch.float32)


@dataclass(frozen=True)
class JacobianParams:
    """The Jacobian of the hand by the joints: a network of the hand's pose."""

    hidden: int = 128
    steps: int = 4000
    batch: int = 512
    learning_rate: float = 3e-3


class HandSteps(NamedTuple):
    """How joints and hand moved from one row of demonstrations to the next.

    Attributes:
        poses: (N, 9), where the hand was (`POSE_NAMES`).
        joints: (N, J) rad, by how much each joint moved.
        hand: (N, 6), by how much the hand moved: translation above rotation vector, in units of
            `HAND_UNITS`, in the frame of the hand's azimuth.
    """

    poses: Tensor
    joints: Tensor
    hand: Tensor


class HandJacobian(Conditioned):
    """The motion of the hand by each action of 1, (B, 6, J), where observations (B, D) have it.

    In units of `HAND_UNITS`, in the frame of the hand's azimuth: there an
    arm whose first joint is vertical has the same Jacobian whichever way it is turned.

    Attributes:
        scale: (J,) rad that an action of 1 moves each joint.
    """

    scale: Tensor

    def __init__(self, joints: int, hidden: int) -> None:
        super().__init__(POSE_NAMES, turned=True)
        self.joints, self.hidden = joints, hidden
        self.register_buffer("scale", torch.ones(joints))
        self.network = nn.Sequential(
            nn.Linear(self.feature_size, hidden), nn.SiLU(),
            nn.Linear(hidden, hidden), nn.SiLU(),
            nn.Linear(hidden, 6 * self.joints),
        )  # fmt: skip

    def forward(self, observations: Tensor) -> Tensor:
        return self.by_joints(observations) * self.scale

    def by_joints(self, observations: Tensor) -> Tensor:
        """The same for each joint's motion by 1 rad."""
        return self.network(self.features(observations)).unflatten(-1, (6, self.joints))


def hand_steps(demonstrations: DemonstrationSet) -> HandSteps | None:
    """The steps of all episodes, thinned; None where the joints are not recorded."""
    joints, observations = demonstrations.joint_positions, demonstrations.observations
    if joints is None:
        return None
    within = torch.ones(len(demonstrations), dtype=torch.bool)
    within[demonstrations.starts[1:] - 1] = False  # the last row of an episode
    before = thinned(within.nonzero()[:, 0])
    poses, after = observations[before, : len(POSE_NAMES)], observations[before + 1]
    turned = _rotations(after) @ _rotations(poses).mT
    hand = torch.cat(
        [_at_azimuth(after[:, :3] - poses[:, :3], poses),
         _at_azimuth(_rotation_vectors(turned).float(), poses)], dim=-1,
    )  # fmt: skip
    return HandSteps(poses, joints[before + 1] - joints[before], hand / _UNITS)


def train_jacobian(
    steps: HandSteps, scale: Sequence[float], params: JacobianParams, seed: int
) -> HandJacobian:
    """The Jacobian J(x) that explains the steps best, hand = J(x) joints, by squared error.

    Args:
        scale: (J,) rad that an action of 1 moves each joint.
    """
    torch.manual_seed(seed)
    generator = torch.Generator().manual_seed(seed)
    jacobian = HandJacobian(len(scale), params.hidden)
    jacobian.scale.copy_(torch.tensor(scale))
    assert jacobian.normalizer is not None
    jacobian.normalizer.fit(steps.poses, POSE_NAMES)
    features = jacobian.features(steps.poses)
    weights = trainable(jacobian)
    adam = FlatAdam(flatten_parameters(jacobian), params.learning_rate)
    for step in range(params.steps):
        drawn = torch.randint(len(features), (params.batch,), generator=generator)
        found = jacobian.network(features[drawn]).unflatten(-1, (6, jacobian.joints))
        moved = (found @ steps.joints[drawn, :, None])[..., 0]
        loss = ((moved - steps.hand[drawn]) / TYPICAL).square().sum(-1).mean()
        gradient = torch.cat([g.reshape(-1) for g in torch.autograd.grad(loss, weights)])
        adam.lr = annealed(params.learning_rate, step, params.steps)
        adam.descend(clip_norm(gradient, MOST_NORM))
    return jacobian.eval()


def hand_motion(actions: Tensor, observations: Tensor, jacobian: Tensor | None = None) -> Tensor:
    """What actions (B, H, A) ask of hand and gripper, (B, H, 7).

    Translation, rotation and gripper, in units of `HAND_UNITS` and in the
    frame of the hand's azimuth, where observations (B, D) have the hand.

    Args:
        jacobian: (B, 6, A - 1) of `HandJacobian`, for actions that are joint motions; None for such
            as are the hand's motion in the base frame themselves.
    """
    motion, gripper = actions[..., :-1], actions[..., -1:]
    if jacobian is not None:
        return torch.cat([motion @ jacobian.mT, gripper], dim=-1)
    parts = [_at_azimuth(part, observations[:, None]) for part in motion.split(3, dim=-1)]
    return torch.cat([*parts, gripper], dim=-1)


@torch.no_grad()
def jacobian_error(jacobian: HandJacobian, steps: HandSteps) -> float:
    """Root of the mean squared error of the hand's motion over that of the motion itself."""
    moved = (jacobian.by_joints(steps.poses) @ steps.joints[..., None])[..., 0]
    return float(((moved - steps.hand).square().sum() / steps.hand.square().sum()).sqrt())


def _rotations(observations: Tensor) -> Tensor:
    """Rotation matrices (N, 3, 3), float64, of observations that begin with `POSE_NAMES`."""
    x, y = observations[:, 3:9].double().unflatten(-1, (2, 3)).unbind(1)
    return torch.stack([x, y, torch.linalg.cross(x, y)], dim=-1)


def _rotation_vectors(rotations: Tensor) -> Tensor:
    """(N, 3) rad of rotation matrices (N, 3, 3) by less than half a turn."""
    skew = 0.5 * (rotations - rotations.mT)
    sines = torch.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], dim=-1)
    sine = torch.linalg.vector_norm(sines, dim=-1, keepdim=True)
    cosine = 0.5 * (rotations.diagonal(dim1=1, dim2=2).sum(-1, keepdim=True) - 1.0)
    return sines * torch.where(sine > 1e-9, torch.atan2(sine, cosine) / sine.clamp_min(1e-9), 1.0)


def _at_azimuth(vectors: Tensor, poses: Tensor) -> Tensor:
    """Vectors (..., 3) of the base frame in the frame of the azimuth of hands at poses (..., D)."""
    x, y, z = vectors.unbind(-1)
    cos, sin = azimuth(poses).unbind(-1)
    return torch.stack([cos * x + sin * y, cos * y - sin * x, z], dim=-1)
