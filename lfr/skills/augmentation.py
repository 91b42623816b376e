"""Action windows that were not demonstrated but could have been, for a VAE that must say new ones.

A target's decoder has seen the common tasks only, and still has to express the new one: motion in
other directions, at other speeds.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from lfr.skills.symmetry import ANY_DIRECTION, SceneMotion, move_actions, suited

SCALE_RANGE = (0.6, 1.2)


def augment(actions: Tensor, names: Sequence[str], generator: torch.Generator) -> Tensor:
    """Turn each window about the vertical, mirror half of them, scale their motion, swap hands.

    What is not known of a controller's actions is left out (`lfr.skills.symmetry.suited`).

    The gripper's commands come from another of the windows: what the hand does and where the arm
    goes are then told apart, and a new task may combine them anew.

    Args:
        actions: (B, H, A), the gripper last.
        names: of their dimensions.

    Returns:
        Windows of the same shape in [-1, 1].
    """
    low, high = SCALE_RANGE
    scale = low + (high - low) * torch.rand(len(actions), 1, 1, generator=generator)
    motion = SceneMotion.draw(len(actions), suited(ANY_DIRECTION, names), generator)
    moved = move_actions(actions, names, motion)
    gripper = actions[torch.randperm(len(actions), generator=generator), :, -1:]
    return torch.cat([(scale * moved[..., :-1]).clamp(-1.0, 1.0), gripper], dim=-1)
