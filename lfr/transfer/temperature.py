"""The temperature alpha of the divergence in Eq. 9, by dual descent."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn


class Temperature(nn.Module):
    """alpha = exp(log_alpha) > 0, so the multiplier of the constraint KL <= target never flips."""

    def __init__(self, initial_alpha: float) -> None:
        super().__init__()
        self.log_alpha = nn.Parameter(torch.tensor(math.log(initial_alpha)))

    def forward(self) -> Tensor:
        """alpha, a scalar without gradient: the losses of policy and critics take it as given."""
        return self.log_alpha.detach().exp()

    def loss(self, kl: Tensor, target_divergence: float) -> Tensor:
        """Its descent raises alpha while KL > target and lowers it while KL < target."""
        return self.log_alpha * (target_divergence - kl.detach())
