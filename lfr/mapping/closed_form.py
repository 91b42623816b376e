"""Maps that need no descent: the best linear one, and the one that ignores what it is given."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from lfr.mapping.generator import Generator


@torch.no_grad()
def linear(k_x: Tensor, k_y: Tensor) -> Generator:
    """k_y = W k_x + b with the least squared error over pairs (N, 2Z), all dimensions alike."""
    g, layer = _one_layer(k_x)
    g.fit_scales(k_x, k_y)
    x = ((k_x - g.centre_in) / g.scale_in).double()
    y = ((k_y - g.centre_out) / g.scale_out).double()
    found = torch.linalg.lstsq(torch.cat([x, torch.ones(len(x), 1)], dim=-1), y).solution
    layer.weight.copy_(found[:-1].T)
    layer.bias.copy_(found[-1])
    return g.eval()


@torch.no_grad()
def constant(k_x: Tensor, k_y: Tensor) -> Generator:
    """The mean of k_y (N, 2Z), whatever comes: what G does without looking."""
    g, layer = _one_layer(k_x)
    g.fit_scales(k_x, k_y)
    layer.weight.zero_()
    layer.bias.zero_()
    return g.eval()


def _one_layer(k_x: Tensor) -> tuple[Generator, nn.Linear]:
    size = k_x.shape[-1]
    g = Generator(size // 2, hidden=size, layers=1)
    layer = g.network[-1]
    assert isinstance(layer, nn.Linear)
    return g, layer
