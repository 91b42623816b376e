"""G and F as one network while they learn, and the gradient of Eq. 4."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from lfr.mapping.generator import Generator
from lfr.networks.device import CPU
from lfr.networks.stacked import Stacked


class GeneratorPair:
    """G: X -> Y and F: Y -> X, side by side, in the same states where they see these.

        L_reg = ||k_x - F(k_y)||_1 + ||k_y - G(k_x)||_1                        (5)
        L_cyc = ||F(G(k_x)) - k_x||_1 + ||G(F(k_y)) - k_y||_1                  (6)
        L     = L_reg + lambda L_cyc                                           (4)

    Norms are summed over the 2Z numbers of a distribution and averaged over the batch. Each
    generator standardises what the other gives, so both work between standardised distributions,
    and a difference there counts by its dimension's scale.

    Attributes:
        networks: what learns of them.
    """

    def __init__(self, g: Generator, f: Generator, device: torch.device = CPU) -> None:
        self.networks = Stacked([g.network, f.network], device)
        self._centre = torch.stack([g.centre_in, f.centre_in])[:, None].to(device)  # of X and of Y
        self._scale = torch.stack([g.scale_in, f.scale_in])[:, None].to(device)

    def standardised(self, k_x: Tensor, k_y: Tensor) -> Tensor:
        """k_x and k_y (N, 2Z) as the networks take them, (2, N, 2Z)."""
        pairs = torch.stack([k_x, k_y]).to(self._centre.device)
        return (pairs - self._centre) / self._scale

    @torch.no_grad()
    def gradient(self, known: Tensor, weight: float, features: Tensor | None = None) -> Tensor:
        """Of Eq. 4 with lambda = ``weight`` by all parameters, (P,), at pairs (2, B, 2Z).

        Args:
            features: what both see of the states beside, (B, F).
        """
        expected = known.flip(0)
        per_row = self._scale.flip(0) / known.shape[1]
        there, traces = self.networks.evaluate(_beside(known, features))
        slope = torch.sign(there - expected) * per_row
        if not weight:
            return self.networks.by_parameters(traces, slope)
        # What G gave is F's input, and the other way round.
        back, traces_back = self.networks.evaluate(_beside(there.flip(0), features))
        slope_back = torch.sign(back - expected) * (weight * per_row)
        cycle, by_inputs = self.networks.by_parameters_and_inputs(traces_back, slope_back)
        cycle = cycle.clone()
        by_there = by_inputs[..., : known.shape[2]].flip(0)
        return self.networks.by_parameters(traces, slope + by_there).add_(cycle)

    @torch.no_grad()
    def gradient_of_mapped(
        self,
        known_x: Tensor,
        slope: Callable[[Tensor], Tensor],
        features: Tensor | None = None,
    ) -> Tensor:
        """Of a loss of k_y = G(k_x) by all parameters, (P,); F's are zero.

        Args:
            known_x: standardised, (B, 2Z).
            slope: gives dL/dk_y (B, 2Z) for k_y (B, 2Z).
        """
        there, traces = self.networks.evaluate(_beside(known_x.expand(2, -1, -1), features))
        by_there = torch.zeros_like(there)
        with torch.enable_grad():
            by_there[0] = slope(there[0] * self._scale[1] + self._centre[1])
        by_there[0] *= self._scale[1]
        return self.networks.by_parameters(traces, by_there)


def _beside(k: Tensor, features: Tensor | None) -> Tensor:
    """The networks' inputs (2, B, 2Z + F)."""
    return k if features is None else torch.cat([k, features.expand(2, -1, -1)], dim=-1)
