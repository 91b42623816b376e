"""Demonstrations seen from elsewhere: the whole scene turned, mirrored and shifted.

Under Cartesian control an arm's task looks the same in a scene that is turned about the vertical,
mirrored, or shifted, up to its reach: the demonstrator would do the turned, mirrored actions. So
fifty demonstrations tell more than fifty, and a prior cannot learn an episode by heart from where
its objects stand. It does not hold for asymmetric hands.

Under joint control the demonstrator would do the same actions in a scene that is turned, and there
no copies are needed: a prior sees the scene in the frame of the hand's azimuth, in which all turned
copies are one (`lfr.skills.normalizer.Normalizer`). Of the other two, the hand's Jacobian says what
the joints would do (`lfr.skills.moved_joints`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from lfr.errors import LfrError
from lfr.skills.rows import MOST_ROWS
from lfr.spaces import space


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
    """One motion per row.

    Attributes:
        angle: (B,) rad, of a turn about the base's vertical.
        mirror: (B,) -1 for a mirror y -> -y before it, else 1.
        shift: (B, 3) m, by which every position moves after it.
        turns_alone: whether nothing is mirrored or shifted.
    """

    angle: Tensor
    mirror: Tensor
    shift: Tensor
    turns_alone: bool = False

    @classmethod
    def draw(cls, count: int, params: SymmetryParams, generator: torch.Generator) -> SceneMotion:
        angle = params.turn * (2.0 * torch.rand(count, generator=generator) - 1.0)
        flip = torch.rand(count, generator=generator) < 0.5
        mirror = torch.where(flip, -1.0, 1.0) if params.mirror else torch.ones(count)
        shift = params.shift * (2.0 * torch.rand(count, 3, generator=generator) - 1.0)
        shift[:, 2] *= 0.5  # bases stand at different heights above their tables
        return cls(angle, mirror, shift, not params.mirror and params.shift == 0.0)

    def vectors(self, vectors: Tensor) -> Tensor:
        """Directions and distances (B, ..., 3) after the motion."""
        angle, mirror = (self._per_row(value, vectors) for value in (self.angle, self.mirror))
        x, y, z = vectors.unbind(-1)
        cos, sin, y = torch.cos(angle), torch.sin(angle), mirror * y
        return torch.stack([cos * x - sin * y, sin * x + cos * y, z], dim=-1)

    def rotations(self, rotation_vectors: Tensor) -> Tensor:
        """Rotation vectors (B, ..., 3): axial, so a mirror turns them the other way round."""
        mirror = self._per_row(self.mirror, rotation_vectors)
        return self.vectors(rotation_vectors) * mirror[..., None]

    @staticmethod
    def _per_row(value: Tensor, vectors: Tensor) -> Tensor:
        return value.reshape(-1, *[1] * (vectors.dim() - 2))


def move(vectors: Tensor, names: Sequence[str], motion: SceneMotion) -> Tensor:
    """Observations or actions (B, ..., D), their dimensions called ``names``, in the moved scene.

    Raises:
        LfrError: a quantity of which it is not known how it moves.
    """
    moved = vectors.clone()
    for quantity, place in space(names).items():
        values = vectors[..., place]
        match quantity.moves:
            case "point":
                moved[..., place] = motion.vectors(values) + motion.shift
            case "vector":
                moved[..., place] = motion.vectors(values)
            case "axial":
                moved[..., place] = motion.rotations(values)
            case "rotation":
                columns = motion.vectors(values.unflatten(-1, (2, 3)))
                # A mirror image of a frame is left-handed; the hand is symmetric, so its y axis
                # turns.
                columns[..., 1, :] = columns[..., 1, :] * motion.mirror[:, None]
                moved[..., place] = columns.flatten(-2)
            case "relative angle":  # unchanged by a turn, reversed by a mirror
                moved[..., place.start + 1] = values[..., 1] * motion.mirror
            case "not at all":
                pass
            case "with the base" if motion.turns_alone:
                pass
            case _:
                raise LfrError(f"how {quantity.name!r} moves with the scene is not known")
    return moved


def move_actions(actions: Tensor, names: Sequence[str], motion: SceneMotion) -> Tensor:
    """Actions (B, H, A) in the moved scene, within [-1, 1]."""
    return move(actions, names, motion).clamp(-1.0, 1.0)


def suited(params: SymmetryParams, names: Sequence[str]) -> SymmetryParams:
    """What is known of how an action moves with the scene, of what ``params`` asks for.

    Joint motions stay as they are where the scene is turned about the vertical of a base whose
    first joint is vertical, as every arm's here is; nothing else is known of them, and who sees the
    scene in the frame of the hand's azimuth needs no turned copies.
    """
    moves = {quantity.moves for quantity in space(names).quantities}
    return AS_RECORDED if moves & {"unknown", "with the base"} else params


def moved_copies(
    observations: Tensor,
    actions: Tensor,
    names: Sequence[str],
    action_names: Sequence[str],
    params: SymmetryParams,
    generator: torch.Generator,
) -> tuple[Tensor, Tensor]:
    """The windows (N, D), (N, H, A) and moved copies of each after them."""
    copies = params.copies_of(len(observations))
    if copies == 0:
        return observations, actions
    params = suited(params, action_names)
    copies = params.copies_of(len(observations))
    if copies == 0:
        return observations, actions
    many_o, many_a = observations.repeat(copies, 1), actions.repeat(copies, 1, 1)
    motion = SceneMotion.draw(len(many_o), params, generator)
    seen = torch.cat([observations, move(many_o, names, motion)])
    done = torch.cat([actions, move_actions(many_a, action_names, motion)])
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
    return torch.cat([observations, move(many, names, motion)])


def actions_turn_with_base(names: Sequence[str]) -> bool:
    """Whether actions called ``names`` stay as they are where scene and arm are turned together."""
    return any(quantity.moves == "with the base" for quantity in space(names).quantities)


def turning(names: Sequence[str]) -> list[tuple[int, int]]:
    """Where the x and the y of all that turns with the scene are, of dimensions called ``names``.

    Raises:
        LfrError: a quantity of which it is not known how it moves.
    """
    places: list[tuple[int, int]] = []
    for quantity, place in space(names).items():
        if quantity.moves in ("point", "vector", "axial", "rotation"):
            places += [(x, x + 1) for x in range(place.start, place.stop, 3)]
        elif quantity.moves not in ("not at all", "relative angle"):
            raise LfrError(f"how {quantity.name!r} moves with the scene is not known")
    return places


AS_RECORDED = SymmetryParams(copies=0, turn=0.0, shift=0.0, mirror=False)
"""For arms of which it is not known how their actions move with the scene."""

ANY_DIRECTION = SymmetryParams(copies=1, turn=math.pi, shift=0.0)
"""For the VAE, whose windows have no place in the scene: any direction is as good."""
