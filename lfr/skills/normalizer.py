"""What networks see of an observation: normalised, and magnified where millimetres decide."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from lfr.skills.symmetry import turning
from lfr.spaces import space

# Distances to a goal vary over decimetres and decide at millimetres (the nut's hole leaves 6.75 mm
# around the peg), so they enter twice: as they are, and magnified near zero.
FINE_SCALE = 0.01

# Likewise the tilt of a hand that should point straight down, in rad. It is a cross product of the
# rotation's columns, which a small network that sees tilts of a few hundredths hardly finds.
TILT_SCALE = 0.1


def azimuth(positions: Tensor) -> Tensor:
    """Cosine and sine (..., 2) of the azimuth of positions (..., 3 or more) in the base frame."""
    horizontal = positions[..., :2]
    return horizontal / torch.linalg.vector_norm(horizontal, dim=-1, keepdim=True).clamp_min(1e-6)


class Normalizer(nn.Module):
    """What a prior sees of observations (B, D): (B, D + F + 2 R), F of them distances, R rotations.

    (x - mean) / std with the demonstrations' statistics, std floored per input, then
    tanh(x / FINE_SCALE) of each distance x (m), then tanh(x / TILT_SCALE) of the horizontal
    components x of each rotation's z axis.

    Args:
        turned: whether all this is of the scene in the frame of the hand's azimuth: turned about
            the base's vertical until the hand is over the x axis. An arm whose first joint is
            vertical does the same joint motions in all these scenes, so to its prior they are one.
    """

    mean: Tensor
    std: Tensor
    distances: Tensor
    rotations: Tensor
    turning: Tensor

    def __init__(self, names: Sequence[str], *, turned: bool = False) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(len(names)))
        self.register_buffer("std", torch.ones(len(names)))
        each = space(names).each()
        places = [place for place, quantity in enumerate(each) if quantity.to_zero]
        self.register_buffer("distances", torch.tensor(places, dtype=torch.long), persistent=False)
        columns = [place for place, quantity in enumerate(each) if quantity.moves == "rotation"]
        rotations = torch.tensor(columns, dtype=torch.long).reshape(-1, 2, 3)
        self.register_buffer("rotations", rotations, persistent=False)
        pairs = torch.tensor(turning(names) if turned else [], dtype=torch.long).reshape(-1, 2)
        self.register_buffer("turning", pairs, persistent=False)  # x and y of what turns
        self.turned = turned
        self.hand = [*names].index("eef_pos.x") if turned else 0
        self.size = len(names) + len(places) + 2 * len(rotations)

    @torch.no_grad()
    def fit(self, observations: Tensor, names: Sequence[str]) -> None:
        """Take mean and floored standard deviation from observations (N, D) named ``names``."""
        floors = torch.tensor([quantity.std_floor for quantity in space(names).each()])
        observations = self.at_azimuth_zero(observations)
        self.mean.copy_(observations.mean(0))
        self.std.copy_(torch.maximum(observations.std(0), floors))

    def at_azimuth_zero(self, observations: Tensor) -> Tensor:
        """The observations (B, D), in the frame of the hand's azimuth where that is asked for."""
        if not self.turned:
            return observations
        cos, sin = azimuth(observations[:, self.hand :]).T
        of_x, of_y = self.turning.T
        x, y = observations[:, of_x], observations[:, of_y]
        turned = observations.clone()
        turned[:, of_x] = cos[:, None] * x + sin[:, None] * y
        turned[:, of_y] = cos[:, None] * y - sin[:, None] * x
        return turned

    def forward(self, observations: Tensor) -> Tensor:
        observations = self.at_azimuth_zero(observations)
        fine = torch.tanh(observations[:, self.distances] / FINE_SCALE)
        x, y = observations[:, self.rotations].unbind(2)  # (B, R, 3) each
        tilt = torch.tanh(torch.linalg.cross(x, y)[..., :2].flatten(1) / TILT_SCALE)
        return torch.cat([(observations - self.mean) / self.std, fine, tilt], dim=-1)

    def noise_scale(self) -> Tensor:
        """What counts as a unit of noise for each input, (D,): its std, or the fine scale."""
        scale = self.std.clone()
        scale[self.distances] = FINE_SCALE
        return scale
