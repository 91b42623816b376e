"""Critics Q(s, z) over observations and skills, an ensemble computed as one network."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional as F

# A state further out than this was never near the demonstrations; a larger input would only make
# the critics extrapolate.
OBSERVATION_CLIP = 10.0


class EnsembleLinear(nn.Module):
    """E independent linear layers, (E, B, in) -> (E, B, out), initialised as ``nn.Linear`` is."""

    def __init__(self, ensemble: int, inputs: int, outputs: int) -> None:
        super().__init__()
        bound = 1.0 / math.sqrt(inputs)
        self.weight = nn.Parameter(torch.empty(ensemble, inputs, outputs).uniform_(-bound, bound))
        self.bias = nn.Parameter(torch.empty(ensemble, 1, outputs).uniform_(-bound, bound))

    def forward(self, x: Tensor) -> Tensor:
        return torch.baddbmm(self.bias, x, self.weight)


class EnsembleLayerNorm(nn.Module):
    """Layer normalisation with each member's own scale and shift, (E, B, features)."""

    def __init__(self, ensemble: int, features: int) -> None:
        super().__init__()
        self.features = features
        self.scale = nn.Parameter(torch.ones(ensemble, 1, features))
        self.shift = nn.Parameter(torch.zeros(ensemble, 1, features))

    def forward(self, x: Tensor) -> Tensor:
        return torch.addcmul(self.shift, F.layer_norm(x, (self.features,)), self.scale)


class CriticEnsemble(nn.Module):
    """Q_e(s, z) for e = 1..E: observations (B, D) and skills (B, Z) to values (E, B).

    ``normalizer`` maps raw observations to unit scale; it has no trainable parameters.
    """

    def __init__(
        self,
        normalizer: nn.Module,
        observation_dim: int,
        latent_dim: int,
        ensemble: int,
        hidden: Sequence[int],
        *,
        layer_norm: bool,
    ) -> None:
        super().__init__()
        self.normalizer = normalizer
        self.ensemble = ensemble
        widths = [observation_dim + latent_dim, *hidden]
        blocks: list[nn.Module] = []
        for inputs, outputs in itertools.pairwise(widths):
            blocks.append(EnsembleLinear(ensemble, inputs, outputs))
            if layer_norm:
                blocks.append(EnsembleLayerNorm(ensemble, outputs))
            blocks.append(nn.ReLU())
        self.network = nn.Sequential(*blocks, EnsembleLinear(ensemble, widths[-1], 1))

    def inputs(self, observation: Tensor) -> Tensor:
        """The normalised observations (B, D) that several calls of ``values`` can share."""
        return self.normalizer(observation).clamp(-OBSERVATION_CLIP, OBSERVATION_CLIP)

    def values(self, inputs: Tensor, z: Tensor) -> Tensor:
        """Q (E, B) at normalised observations (B, D) and skills (B, Z)."""
        x = torch.cat([inputs, z], dim=-1)
        return self.network(x.expand(self.ensemble, -1, -1)).squeeze(-1)

    def forward(self, observation: Tensor, z: Tensor) -> Tensor:
        return self.values(self.inputs(observation), z)


def pessimistic(q: Tensor, members: Tensor | None = None) -> Tensor:
    """Double-Q: the minimum (B,) over the ensemble's values (E, B), or over some of its members."""
    return (q if members is None else q[members]).amin(0)


def td_target(
    reward: Tensor, discount: Tensor, next_q: Tensor, alpha: Tensor, kl: Tensor
) -> Tensor:
    """y = r + discount (Q(s', z') - alpha KL(pi'(.|s') || phi(p_a(.|s')))), (B,).

    Eq. 9 in place of SAC's entropy. ``discount`` is gamma, or 0 after a terminal state; a time
    limit is none, so it bootstraps. Time is counted in skills, not in control steps.
    """
    return reward + discount * (next_q - alpha * kl)


def critic_loss(q: Tensor, target: Tensor) -> Tensor:
    """Squared TD error of (E, B) values against (B,) targets: mean over B, summed over E."""
    return (q - target).square().mean(-1).sum()
