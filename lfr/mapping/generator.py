"""G: X -> Y and F: Y -> X, which translate one arm's skill distributions into the other's."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn

from lfr.skills.condition import Conditioned
from lfr.skills.gaussian import LOG_SIGMA_RANGE


class Generator(Conditioned):
    """Maps ``(mu, log_sigma)`` (B, Z) of one latent space to those of another.

    Three fully connected layers (part V.A) over k = [mu, log sigma]. Inputs and outputs are
    standardised inside by the training distribution, which conditions the network only: the losses
    of Eq. 5 and 6 compare k itself, so a latent dimension that carries little weighs little.

    Args:
        state_names: what it sees of the state beside k, the first dimensions of an observation:
            G(k, s). None of them is the paper's G(k). Where actions are motions of an arm's joints,
            the same skill is another motion of the hand in another posture.
        turned: whether it sees that in the frame of the hand's azimuth (`Normalizer`).
    """

    centre_in: Tensor
    scale_in: Tensor
    centre_out: Tensor
    scale_out: Tensor

    def __init__(
        self,
        latent_dim: int,
        hidden: int,
        layers: int,
        state_names: Sequence[str] = (),
        turned: bool = False,
    ) -> None:
        super().__init__(state_names, turned)
        self.latent_dim, self.hidden, self.layers = latent_dim, hidden, layers
        size = 2 * latent_dim
        for name, value in (("centre", torch.zeros(size)), ("scale", torch.ones(size))):
            self.register_buffer(f"{name}_in", value.clone())
            self.register_buffer(f"{name}_out", value.clone())
        widths = [size + self.feature_size] + [hidden] * (layers - 1)
        blocks: list[nn.Module] = []
        for inputs, outputs in pairwise(widths):
            blocks += [nn.Linear(inputs, outputs), nn.LeakyReLU(0.2)]
        self.network = nn.Sequential(*blocks, nn.Linear(widths[-1], size))

    def forward(
        self, mu: Tensor, log_sigma: Tensor, features: Tensor | None = None
    ) -> tuple[Tensor, Tensor]:
        k = self.translate(torch.cat([mu, log_sigma], dim=-1), features)
        mu, log_sigma = k.chunk(2, dim=-1)
        return mu, log_sigma.clamp(*LOG_SIGMA_RANGE)

    def at(self, mu: Tensor, log_sigma: Tensor, observation: Tensor) -> tuple[Tensor, Tensor]:
        """`forward` in the states of observations (B, D)."""
        return self(mu, log_sigma, self.features(observation))

    def translate(self, k: Tensor, features: Tensor | None = None) -> Tensor:
        """k of the other space for k = [mu, log sigma] (B, 2Z) of this one.

        Args:
            features: `features` of the observations; None for a G(k).
        """
        return self.read(self.network(self.inputs(k, features)))

    def inputs(self, k: Tensor, features: Tensor | None = None) -> Tensor:
        """What the network is given, (B, 2Z + F): k standardised, `features` beside it."""
        x = (k - self.centre_in) / self.scale_in
        return x if features is None else torch.cat([x, features], dim=-1)

    def read(self, y: Tensor) -> Tensor:
        """k of the other space (B, 2Z) for what the network gives (B, 2Z)."""
        return y * self.scale_out + self.centre_out

    @torch.no_grad()
    def fit_scales(self, k_in: Tensor, k_out: Tensor, states: Tensor | None = None) -> None:
        """Take the standardisation from distributions (N, 2Z) of both spaces, and states (N, S)."""
        for name, k in (("in", k_in), ("out", k_out)):
            getattr(self, f"centre_{name}").copy_(k.mean(0))
            getattr(self, f"scale_{name}").copy_(k.std(0).clamp_min(0.05))
        if self.normalizer is not None and states is not None:
            self.normalizer.fit(states, self.state_names)
