"""The temperature alpha of the divergence in Eq. 9, by dual descent."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from lfr.networks.device import CPU


class Temperature:
    """alpha = exp(log_alpha) > 0, so the multiplier of the constraint KL <= target never flips."""

    def __init__(self, initial_alpha: float, device: torch.device = CPU) -> None:
        self.log_alpha = torch.tensor([math.log(initial_alpha)], device=device)

    def __call__(self) -> Tensor:
        """alpha, a scalar without gradient: the losses of policy and critics take it as given."""
        return self.log_alpha.exp().squeeze(0)

    def gradient(self, kl: Tensor, target_divergence: float) -> Tensor:
        """Of log_alpha (target - KL) by log_alpha, (1,).

        Its descent raises alpha while KL > target and lowers it while KL < target.
        """
        return (target_divergence - kl).reshape(1)
