"""The skill prior p_a(z|s) of an arm and task: the skills its demonstrator uses in a state."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn

from lfr.skills.vae import LOG_SIGMA_RANGE
from lfr.spaces import space

# Distances to a goal vary over decimetres and decide at millimetres (the nut's hole leaves 6.75 mm
# around the peg), so they enter twice: as they are, and magnified near zero.
FINE_SCALE = 0.01


# Likewise the tilt of a hand that should point straight down, in rad. It is a cross product of the
# rotation's columns, which a small network that sees tilts of a few hundredths hardly finds.
TILT_SCALE = 0.1

NEGATIVE_SLOPE = 0.2  # of the activations


class Normalizer(nn.Module):
    """What a prior sees of observations (B, D): (B, D + F + 2 R), F of them distances, R rotations.

    (x - mean) / std with the demonstrations' statistics, std floored per input, then
    tanh(x / FINE_SCALE) of each distance x (m), then tanh(x / TILT_SCALE) of the horizontal
    components x of each rotation's z axis.
    """

    mean: Tensor
    std: Tensor
    distances: Tensor
    rotations: Tensor

    def __init__(self, names: Sequence[str]) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(len(names)))
        self.register_buffer("std", torch.ones(len(names)))
        each = space(names).each()
        places = [place for place, quantity in enumerate(each) if quantity.to_zero]
        self.register_buffer("distances", torch.tensor(places, dtype=torch.long), persistent=False)
        columns = [place for place, quantity in enumerate(each) if quantity.moves == "rotation"]
        rotations = torch.tensor(columns, dtype=torch.long).reshape(-1, 2, 3)
        self.register_buffer("rotations", rotations, persistent=False)
        self.size = len(names) + len(places) + 2 * len(rotations)

    @torch.no_grad()
    def fit(self, observations: Tensor, names: Sequence[str]) -> None:
        """Take mean and floored standard deviation from observations (N, D) named ``names``."""
        floors = torch.tensor([quantity.std_floor for quantity in space(names).each()])
        self.mean.copy_(observations.mean(0))
        self.std.copy_(torch.maximum(observations.std(0), floors))

    def forward(self, observations: Tensor) -> Tensor:
        fine = torch.tanh(observations[:, self.distances] / FINE_SCALE)
        x, y = observations[:, self.rotations].unbind(2)  # (B, R, 3) each
        tilt = torch.tanh(torch.linalg.cross(x, y)[..., :2].flatten(1) / TILT_SCALE)
        return torch.cat([(observations - self.mean) / self.std, fine, tilt], dim=-1)

    def noise_scale(self) -> Tensor:
        """What counts as a unit of noise for each input, (D,): its std, or the fine scale."""
        scale = self.std.clone()
        scale[self.distances] = FINE_SCALE
        return scale


class SkillPrior(nn.Module):
    """Maps observations (B, D), in the layout's units, to ``(mu, log_sigma)`` (B, Z) each.

    An MLP of ``layers`` hidden layers (the paper's six, SPiRL's width 128) without batch
    normalisation, which makes SPiRL's prior depend on what else is in the batch.
    """

    def __init__(
        self, layout_names: Sequence[str], latent_dim: int, hidden: int, layers: int
    ) -> None:
        super().__init__()
        self.layout_names = tuple(layout_names)
        self.latent_dim, self.hidden, self.layers = latent_dim, hidden, layers
        self.normalizer = Normalizer(self.layout_names)
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
