"""Joint motions in a moved scene: those that move the hand there as the demonstrator's did here.

A scene that is shifted or mirrored asks other motions of the joints, and of the hand the shifted or
mirrored ones. Which joint motions these are says the hand's Jacobian, which each arm's own
demonstrations teach (`lfr.skills.hand_motion`). It is as good as that Jacobian: within centimetres,
not for what leaves millimetres.
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
    """The windows (N, D), (N, H, A) and copies of each after them, shifted and mirrored.

    Not turned: who sees the scene in the frame of the hand's azimuth needs no such copies.
    """
    copies = params.copies_of(len(observations))
    if copies == 0:
        return observations, actions
    many_o, many_a = observations.repeat(copies, 1), actions.repeat(copies, 1, 1)
    motion = SceneMotion.draw(len(many_o), replace(params, turn=0.0), generator)
    moved = move(many_o, names, motion)
    done = [
        move_joint_motions(
            many_a[rows], many_o[rows], moved[rows],
            SceneMotion(motion.angle[rows], motion.mirror[rows], motion.shift[rows]), jacobian,
        )
        for rows in torch.arange(len(many_o)).split(CHUNK)
    ]  # fmt: skip
    return torch.cat([observations, moved]), torch.cat([actions, *done])


def move_joint_motions(
    actions: Tensor, here: Tensor, there: Tensor, motion: SceneMotion, jacobian: HandJacobian
) -> Tensor:
    """Actions (B, H, A) in the moved scene, within [-1, 1]: dq' = dq + J'^+ (m' - J' dq).

    m' is the hand's motion J dq, moved as the scene is. So what the hand leaves free stays as it
    was; in a mirror image, where the arm stands otherwise, it stays still.

    Args:
        here, there: (B, D), where the windows begin, and the same in the moved scene.
    """
    J, moved_J = jacobian(here), jacobian(there)  # (B, 6, A - 1), in the frame of the azimuth
    joints = actions[..., :-1]
    translation, rotation = (joints @ J.mT).split(3, dim=-1)
    translation, rotation = (_turned(part, azimuth(here)) for part in (translation, rotation))
    backwards = azimuth(there) * torch.tensor([1.0, -1.0])
    wanted = torch.cat(
        [_turned(motion.vectors(translation), backwards),
         _turned(motion.rotations(rotation), backwards)], dim=-1,
    )  # fmt: skip
    kept = joints * (motion.mirror > 0)[:, None, None]
    damped = moved_J @ moved_J.mT + DAMPING * torch.eye(6)
    inverse = torch.linalg.solve(damped, moved_J)  # (B, 6, A - 1), transposed
    joints = kept + (wanted - kept @ moved_J.mT) @ inverse
    return torch.cat([joints.clamp(-1.0, 1.0), actions[..., -1:]], dim=-1)


def _turned(vectors: Tensor, by: Tensor) -> Tensor:
    """Vectors (B, H, 3) turned about the vertical by angles of which (B, 2) has cosine and sine."""
    x, y, z = vectors.unbind(-1)
    cos, sin = (part[:, None] for part in by.unbind(-1))
    return torch.stack([cos * x - sin * y, sin * x + cos * y, z], dim=-1)
