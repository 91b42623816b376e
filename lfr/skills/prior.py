"""The skill prior p_a(z|s) of an arm and task: the skills its demonstrator uses in a state."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from torch import Tensor, nn

from lfr.skills.gaussian import LOG_SIGMA_RANGE
from lfr.skills.normalizer import Normalizer

NEGATIVE_SLOPE = 0.2  # of the activations


class SkillPrior(nn.Module):
    """Maps observations (B, D), in the layout's units, to ``(mu, log_sigma)`` (B, Z) each.

    An MLP of ``layers`` hidden layers (the paper's six, SPiRL's width 128) without batch
    normalisation, which makes SPiRL's prior depend on what else is in the batch.

    Args:
        turned: whether it sees the scene in the frame of the hand's azimuth (`Normalizer`).
    """

    def __init__(
        self,
        layout_names: Sequence[str],
        latent_dim: int,
        hidden: int,
        layers: int,
        turned: bool = False,
    ) -> None:
        super().__init__()
        self.layout_names = tuple(layout_names)
        self.latent_dim, self.hidden, self.layers = latent_dim, hidden, layers
        self.turned = turned
        self.normalizer = Normalizer(self.layout_names, turned=turned)
        widths = [self.normalizer.size] + [hidden] * layers
        blocks: list[nn.Module] = []
        for inputs, outputs in pairwise(widths):
            blocks += [nn.Linear(inputs, outputs), nn.LeakyReLU(NEGATIVE_SLOPE)]
        self.network = nn.Sequential(*blocks, nn.Linear(hidden, 2 * latent_dim))

    def forward(self, observations: Tensor) -> tuple[Tensor, Tensor]:
        return self.of_features(self.features(observations))

    def features(self, observations: Tensor) -> Tensor:
        """What the network sees of observations (B, D): (B, inputs), by no trained parameter."""
        return self.normalizer(observations)

    def of_features(self, features: Tensor) -> tuple[Tensor, Tensor]:
        """``(mu, log_sigma)`` (B, Z) each, for the `features` of observations."""
        mu, log_sigma = self.network(features).chunk(2, dim=-1)
        return mu, log_sigma.clamp(*LOG_SIGMA_RANGE)
