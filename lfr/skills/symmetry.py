"""Demonstrations seen from elsewhere: the whole scene turned, mirrored and shifted.

Under Cartesian control an arm's task looks the same in a scene that is turned about the vertical,
mirrored, or shifted, up to its reach: the demonstrator would do the turned, mirrored actions. So
fifty demonstrations tell more than fifty, and a prior cannot learn an episode by heart from where
its objects stand. It does not hold for joint-space actions or asymmetric hands.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from lfr.errors import LfrError
from lfr.skills.rows import MOST_ROWS


@dataclass(frozen=True)
class SymmetryParams:
    """How far demonstrations are moved; zero and False keep them as they are, as in the paper."""

    copies: int = 16  # moved copies of each window beside the window itself, within MOST_ROWS
    turn: float = 1.0  # rad, bound on the rotation about the vertical through the base
    shift: float = 0.1  # m, bound on the horizontal shift; half of it up and down
    mirror: bool = True

    def copies_of(self, rows: int) -> int:
        """How many copies so many rows get: the more there are, the less they need them."""
        return max(0, min(self.copies, MOST_ROWS // max(rows, 1) - 1))


@dataclass(frozen=True)
class SceneMotion:
    """One motion per row: turn by ``angle`` (B,), after a mirror y -> -y where ``mirror`` is -1.

    ``shift`` (B, 3) moves every position, in metres.
    """

    angle: Tensor
    mirror: Tensor
    shift: Tensor

    @classmethod
    def draw(cls, count: int, params: SymmetryParams, generator: torch.Generator) -> SceneMotion:
        angle = params.turn * (2.0 * torch.rand(count, generator=generator) - 1.0)
        flip = torch.rand(count, generator=generator) < 0.5
        mirror = torch.where(flip, -1.0, 1.0) if params.mirror else torch.ones(count)
        shift = params.shift * (2.0 * torch.rand(count, 3, generator=generator) - 1.0)
        shift[:, 2] *= 0.5  # bases stand at different heights above their tables
        return cls(angle, mirror, shift)

    def vectors(self, vectors: Tensor) -> Tensor:
        """Directions and distances (B, ..., 3) after the motion."""
        angle, mirror = (self._beside(value, vectors) for value in (self.angle, self.mirror))
        x, y, z = vectors.unbind(-1)
        cos, sin, y = torch.cos(angle), torch.sin(angle), mirror * y
        return torch.stack([cos * x - sin * y, sin * x + cos * y, z], dim=-1)

    def rotations(self, rotation_vectors: Tensor) -> Tensor:
        """Rotation vectors (B, ..., 3): axial, so a mirror turns them the other way round."""
        mirror = self._beside(self.mirror, rotation_vectors)
        return self.vectors(rotation_vectors) * mirror[..., None]

    @staticmethod
    def _beside(value: Tensor, vectors: Tensor) -> Tensor:
        return value.reshape(-1, *[1] * (vectors.dim() - 2))


def move_actions(actions: Tensor, motion: SceneMotion) -> Tensor:
    """OSC_POSE actions (B, H, 7) in the moved scene, within [-1, 1]."""
    translation = motion.vectors(actions[..., :3])
    rotation = motion.rotations(actions[..., 3:6])
    return torch.cat([translation, rotation, actions[..., 6:]], dim=-1).clamp(-1.0, 1.0)


def move_observations(observations: Tensor, names: Sequence[str], motion: SceneMotion) -> Tensor:
    """Observations (B, D), named as by `lfr.sim.layout.Space`, in the moved scene.

    Raises:
        LfrError: a quantity whose behaviour under motion is not known by its name.
    """
    moved = observations.clone()
    groups: dict[str, list[int]] = {}
    for place, name in enumerate(names):
        groups.setdefault(name.split(".")[0], []).append(place)
    for group, places in groups.items():
        values = observations[:, places]
        if group.endswith("_rot6d"):
            columns = motion.vectors(values.reshape(-1, 2, 3))
            # A mirror image of a frame is left-handed; the hand is symmetric, so its y axis turns.
            columns[:, 1] = columns[:, 1] * motion.mirror[:, None]
            moved[:, places] = columns.reshape(-1, 6)
        elif group.endswith("_pos"):
            moved[:, places] = motion.vectors(values) + motion.shift
        elif group.endswith("_up") or "_to_" in group:
            moved[:, places] = motion.vectors(values)
        elif group.endswith("_yaw"):  # relative angles: unchanged by a turn, reversed by a mirror
            moved[:, places[1]] = values[:, 1] * motion.mirror
        elif not group.startswith("gripper_"):
            raise LfrError(f"how does {group!r} move with the scene? lfr.skills.symmetry knows not")
    return moved


def moved_copies(
    observations: Tensor,
    actions: Tensor,
    names: Sequence[str],
    params: SymmetryParams,
    generator: torch.Generator,
) -> tuple[Tensor, Tensor]:
    """The windows (N, D), (N, H, 7) and moved copies of each after them."""
    copies = params.copies_of(len(observations))
    if copies == 0:
        return observations, actions
    many_o, many_a = observations.repeat(copies, 1), actions.repeat(copies, 1, 1)
    motion = SceneMotion.draw(len(many_o), params, generator)
    seen = torch.cat([observations, move_observations(many_o, names, motion)])
    done = torch.cat([actions, move_actions(many_a, motion)])
    return seen, done


def moved_states(
    observations: Tensor, names: Sequence[str], params: SymmetryParams, generator: torch.Generator
) -> Tensor:
    """The observations (N, D) and moved copies of each after them."""
    copies = params.copies_of(len(observations))
    if copies == 0:
        return observations
    many = observations.repeat(copies, 1)
    motion = SceneMotion.draw(len(many), params, generator)
    return torch.cat([observations, move_observations(many, names, motion)])


AS_RECORDED = SymmetryParams(copies=0, turn=0.0, shift=0.0, mirror=False)
"""For arms of which it is not known how their actions move with the scene."""

FULL_TURN = SymmetryParams(copies=1, turn=math.pi, shift=0.0)
"""For the VAE, whose windows have no place in the scene: any direction is as good."""
