"""Joint motions in a shifted scene: those that move the hand there as the demonstrator's did here.

Which joint motions these are says the hand's Jacobian, which each arm's own demonstrations teach
(`lfr.skills.hand_motion`). It is as good as that Jacobian: within centimetres, not for what leaves
millimetres. Mirror images would put the arm into postures that it has never had, and are left out.
"""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from lfr.skills.hand_motion import HandJacobian
from lfr.skills.normalizer import azimuth
from lfr.skills.symmetry import SceneMotion, SymmetryParams, move

CHUNK = 2**13  # windows at once
DAMPING = 1e-3  # of the squared motion of the hand, in its units, by an action of 1


@torch.no_grad()
def moved_joint_copies(
    observations: Tensor,
    actions: Tensor,
    names: tuple[str, ...],
    params: SymmetryParams,
    jacobian: HandJacobian,
    generator: torch.Generator,
) -> tuple[Tensor, Tensor]:
    """The windows (N, D), (N, H, A) and copies of each after them, shifted.

    Not turned: who sees the scene in the frame of the hand's azimuth needs no such copies.
    """
    copies = params.copies_of(len(observations))
    if copies == 0:
        return observations, actions
    many_o, many_a = observations.repeat(copies, 1), actions.repeat(copies, 1, 1)
    shifted = replace(params, turn=0.0, mirror=False)
    moved = move(many_o, names, SceneMotion.draw(len(many_o), shifted, generator))
    done = [
        move_joint_motions(many_a[rows], many_o[rows], moved[rows], jacobian)
        for rows in torch.arange(len(many_o)).split(CHUNK)
    ]
    return torch.cat([observations, moved]), torch.cat([actions, *done])


def move_joint_motions(
    actions: Tensor, here: Tensor, there: Tensor, jacobian: HandJacobian
) -> Tensor:
    """Actions (B, H, A) in the shifted scene, within [-1, 1]: dq' = dq + J'^+ (m - J' dq).

    m is the hand's motion J dq, which a shift leaves as it is; so is what the hand leaves free.

    Args:
        here, there: (B, D), where the windows begin, and the same in the shifted scene.
    """
    J, moved_J = jacobian(here), jacobian(there)  # (B, 6, A - 1), in the frame of the azimuth
    joints = actions[..., :-1]
    backwards = azimuth(there) * torch.tensor([1.0, -1.0])
    parts = (joints @ J.mT).split(3, dim=-1)
    wanted = torch.cat([_turned(_turned(part, azimuth(here)), backwards) for part in parts], -1)
    damped = moved_J @ moved_J.mT + DAMPING * torch.eye(6)
    inverse = torch.linalg.solve(damped, moved_J)  # (B, 6, A - 1), transposed
    joints = joints + (wanted - joints @ moved_J.mT) @ inverse
    return torch.cat([joints.clamp(-1.0, 1.0), actions[..., -1:]], dim=-1)


def _turned(vectors: Tensor, by: Tensor) -> Tensor:
    """Vectors (B, H, 3) turned about the vertical by angles of which (B, 2) has cosine and sine."""
    x, y, z = vectors.unbind(-1)
    cos, sin = (part[:, None] for part in by.unbind(-1))
    return torch.stack([cos * x - sin * y, sin * x + cos * y, z], dim=-1)
