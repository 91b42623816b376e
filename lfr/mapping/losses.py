"""The losses of the cycle generative mapping, Eq. 4 to 6."""

from __future__ import annotations

from torch import Tensor

from lfr.mapping.generator import Generator


def regression_loss(g: Generator, f: Generator, k_x: Tensor, k_y: Tensor) -> Tensor:
    """Eq. 5 for pairs k_x, k_y (B, 2Z) of the same states: ||k_x - F(k_y)||_1 + ||k_y - G(k_x)||_1.

    The norm is summed over the 2Z numbers of a distribution and averaged over the batch.
    """
    return _l1(f.translate(k_y), k_x) + _l1(g.translate(k_x), k_y)


def cycle_loss(g: Generator, f: Generator, k_x: Tensor, k_y: Tensor) -> Tensor:
    """Eq. 6: E_x ||F(G(k_x)) - k_x||_1 + E_y ||G(F(k_y)) - k_y||_1."""
    return _l1(f.translate(g.translate(k_x)), k_x) + _l1(g.translate(f.translate(k_y)), k_y)


def mapping_loss(g: Generator, f: Generator, k_x: Tensor, k_y: Tensor, weight: float) -> Tensor:
    """Eq. 4: L_reg + lambda L_cyc."""
    loss = regression_loss(g, f, k_x, k_y)
    return loss + weight * cycle_loss(g, f, k_x, k_y) if weight else loss


def _l1(predicted: Tensor, expected: Tensor) -> Tensor:
    return (predicted - expected).abs().sum(-1).mean()
