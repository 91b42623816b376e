"""Maps that need no descent: the best linear one, and the one that ignores what it is given."""

from __future__ import annotations

import torch
from torch import nn

from lfr.mapping.generator import Generator
from lfr.mapping.mapping_training import Pairs
from lfr.skills.condition import GIVEN_NOTHING, Condition


@torch.no_grad()
def linear(pairs: Pairs, condition: Condition = GIVEN_NOTHING) -> Generator:
    """k_y = W [k_x, s] + b with the least squared error over pairs, all dimensions alike.

    Args:
        condition: what s is; nothing by default.
    """
    g, layer = _one_layer(pairs, condition)
    x = (pairs.k_x - g.centre_in) / g.scale_in
    if pairs.states is not None:
        x = torch.cat([x, g.features(pairs.states)], dim=-1)
    y = ((pairs.k_y - g.centre_out) / g.scale_out).double()
    ones = torch.ones(len(x), 1, dtype=torch.float64)
    found = torch.linalg.lstsq(torch.cat([x.double(), ones], dim=-1), y).solution
    layer.weight.copy_(found[:-1].T)
    layer.bias.copy_(found[-1])
    return g.eval()


@torch.no_grad()
def constant(pairs: Pairs) -> Generator:
    """The mean of k_y (N, 2Z), whatever comes: what G does without looking."""
    g, layer = _one_layer(pairs._replace(states=None), GIVEN_NOTHING)
    layer.weight.zero_()
    layer.bias.zero_()
    return g.eval()


def _one_layer(pairs: Pairs, condition: Condition) -> tuple[Generator, nn.Linear]:
    size = pairs.k_x.shape[-1]
    g = Generator(size // 2, size, 1, *condition)
    g.fit_scales(*pairs)
    layer = g.network[-1]
    assert isinstance(layer, nn.Linear)
    return g, layer
