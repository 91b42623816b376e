"""The recurrent policy of BC+RNN: an LSTM whose every step gives a mixture of Gaussians.

robomimic's RNNGMMActorNetwork: nothing before the LSTM, one linear map after it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn import functional

from lfr.skills.normalizer import Normalizer

Hidden = tuple[Tensor, Tensor]
"""Hidden and cell state of the LSTM, (layers, B, hidden) each."""


class Mixture(NamedTuple):
    """K diagonal Gaussians over actions: any leading shape, here (B, T).

    `logits` (B, T, K) unnormalised, `means` (B, T, K, A) in (-1, 1), `scales` (B, T, K, A) > 0.
    """

    logits: Tensor
    means: Tensor
    scales: Tensor

    def log_likelihood(self, actions: Tensor) -> Tensor:
        """log p(a) of actions (B, T, A), (B, T), in nats: log sum_k w_k prod_a N(a; mu, sigma)."""
        errors = (actions[..., None, :] - self.means) / self.scales  # (B, T, K, A)
        normalisers = self.scales.log() + 0.5 * math.log(2.0 * math.pi)
        components = -(0.5 * errors.square() + normalisers).sum(-1)  # (B, T, K)
        return torch.logsumexp(self.logits.log_softmax(-1) + components, -1)


class RecurrentGMM(nn.Module):
    """Maps observations (B, T, D), in the layout's units, to a `Mixture` over actions (B, T, A).

    Observations enter as a skill prior sees them (`lfr.skills.normalizer.Normalizer`); robomimic
    takes them as they are, in units that suit the joints and objects of its tasks alike.

    Attributes:
        horizon: steps of the sequences it is trained on, after which its hidden state is reset.
        min_std: under every standard deviation.
    """

    def __init__(
        self,
        layout_names: Sequence[str],
        action_dim: int,
        hidden: int,
        layers: int,
        modes: int,
        min_std: float,
        horizon: int,
    ) -> None:
        super().__init__()
        self.layout_names = tuple(layout_names)
        self.action_dim, self.hidden, self.layers = action_dim, hidden, layers
        self.modes, self.min_std, self.horizon = modes, min_std, horizon
        self.normalizer = Normalizer(self.layout_names)
        self.lstm = nn.LSTM(self.normalizer.size, hidden, layers, batch_first=True)
        self.output = nn.Linear(hidden, modes * (1 + 2 * action_dim))

    def forward(self, observations: Tensor, hidden: Hidden | None = None) -> tuple[Mixture, Hidden]:
        """The mixture of every step, and the state after the last; ``hidden`` None is all zeros."""
        seen = self.normalizer(observations.flatten(0, 1)).unflatten(0, observations.shape[:2])
        features, last = self.lstm(seen, hidden)
        sizes = [self.modes, self.modes * self.action_dim, self.modes * self.action_dim]
        logits, means, scales = self.output(features).split(sizes, -1)
        shape = (self.modes, self.action_dim)
        return Mixture(
            logits,
            means.unflatten(-1, shape).tanh(),
            functional.softplus(scales.unflatten(-1, shape)) + self.min_std,
        ), last
