"""Action windows that were not demonstrated but could have been, for a VAE that must say new ones.

A target's decoder has seen the common tasks only, and still has to express the new one: motion in
other directions, at other speeds.
"""

from __future__ import annotations

import torch
from torch import Tensor

from lfr.skills.symmetry import FULL_TURN, SceneMotion, move_actions

SCALE_RANGE = (0.6, 1.2)


def augment(actions: Tensor, generator: torch.Generator) -> Tensor:
    """Turn each window about the vertical, mirror half of them, scale their motion, swap hands.

    The gripper's commands come from another of the windows: what the hand does and where the arm
    goes are then told apart, and a new task may combine them anew.

    Args:
        actions: (B, H, 7) in the base frame: translation, rotation vector, gripper.

    Returns:
        Windows of the same shape in [-1, 1].
    """
    low, high = SCALE_RANGE
    scale = low + (high - low) * torch.rand(len(actions), 1, 1, generator=generator)
    moved = move_actions(actions, SceneMotion.draw(len(actions), FULL_TURN, generator))
    gripper = actions[torch.randperm(len(actions), generator=generator), :, 6:]
    return torch.cat([(scale * moved[..., :6]).clamp(-1.0, 1.0), gripper], dim=-1)
