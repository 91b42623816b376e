"""An arm's actions carried out by another one as they are, joint by joint, whatever they do there.

The gripper's comes last on either. Of the others those that the arm has no dimension for are left
out, and those that it misses are 0.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from lfr.model_files import ModelKind
from lfr.skills.saved_models import VAE
from lfr.skills.vae import SkillVAE


def resizing(found: int, size: int) -> NDArray[np.float64]:
    """(found, size), which makes of actions (..., found) the ones of an arm with ``size``."""
    matrix = np.zeros((found, size))
    moved = min(found, size) - 1
    matrix[range(moved), range(moved)] = matrix[-1, -1] = 1.0
    return matrix


class ResizedVAE(SkillVAE):
    """A skill VAE whose actions are carried out by an arm with ``size`` of them."""

    resizing: Tensor

    def __init__(
        self,
        horizon: int,
        action_dim: int,
        latent_dim: int,
        hidden: int,
        execute: int | None = None,
        state_names: Sequence[str] = (),
        turned: bool = False,
        whole_release: bool = False,
        size: int = 1,
    ) -> None:
        super().__init__(
            horizon, action_dim, latent_dim, hidden, execute, state_names, turned, whole_release
        )
        self.size = size
        matrix = torch.from_numpy(resizing(action_dim, size)).float()
        self.register_buffer("resizing", matrix, persistent=False)

    def carry_out(self, z: Tensor, observations: Tensor | None = None) -> list[Tensor]:
        """What is carried out of the decoded actions, as the other arm's, (n, size) of each."""
        return [skill @ self.resizing for skill in super().carry_out(z, observations)]


RESIZED_VAE = ModelKind("resized_skill_vae", ResizedVAE, (*VAE.shape, "size"))


def resized_vae(vae: SkillVAE, size: int) -> ResizedVAE:
    """A copy of ``vae`` for an arm whose actions have ``size`` dimensions."""
    resized = ResizedVAE(**VAE.shape_of(vae), size=size)
    resized.load_state_dict(vae.state_dict())
    return resized.eval()
