"""Perceptrons of ``torch.nn`` that learn in place, their gradient written out."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from lfr.networks.ensemble import Shape, Trace, differentiate, evaluate


class Perceptron:
    """A sequence of linear layers and leaky ReLUs, computed as an ensemble of one.

    Args:
        network: its parameters become views of ``vector``, turned: (in, out) there, since the
            product with what is not transposed is the faster one.
        vector, gradient: its part of the parameters and of their gradient, (P,) each.
    """

    def __init__(self, network: nn.Sequential, vector: Tensor, gradient: Tensor) -> None:
        shape = shape_of([network])
        self._slope = shape.slope
        self._layers, self._slopes = shape.layers(vector), shape.layers(gradient)
        for linear, layer in zip(linears_of(network), self._layers, strict=True):
            for own, part in ((linear.weight, layer.weight[0].T), (linear.bias, layer.bias[0, 0])):
                part.copy_(own.data)
                own.data = part

    def evaluate(self, x: Tensor) -> tuple[Tensor, list[Trace]]:
        """Outputs (B, out) for inputs (B, in), and how they came about."""
        outputs, traces = evaluate(self._layers, x[None], self._slope)
        return outputs[0], traces

    def differentiate(
        self, traces: list[Trace], by_outputs: Tensor, *, learns: bool = True, by_x: bool = False
    ) -> Tensor | None:
        """The chain rule for dL/doutputs (B, out).

        Args:
            learns: whether the gradient by the parameters is written, over the one before.
            by_x: whether dL/dx (B, in) is wanted, and returned.
        """
        into = self._slopes if learns else None
        found = differentiate(
            self._layers, traces, by_outputs[None], into, self._slope, by_inputs=by_x
        )
        return None if found is None else found[0]


def perceptrons(networks: Sequence[nn.Sequential]) -> tuple[Tensor, Tensor, list[Perceptron]]:
    """Networks in one vector: all parameters (P,), their gradient (P,), and each network."""
    sizes = [sum(p.numel() for p in network.parameters()) for network in networks]
    first = next(networks[0].parameters())
    vector = torch.zeros(sum(sizes), dtype=first.dtype, device=first.device)
    gradient = torch.zeros_like(vector)
    parts = zip(networks, vector.split(sizes), gradient.split(sizes), strict=True)
    return vector, gradient, [Perceptron(*part) for part in parts]


def shape_of(networks: Sequence[nn.Sequential]) -> Shape:
    """The shape of perceptrons as an ensemble, alike but for the number of their inputs.

    Raises:
        ValueError: there is something else in one than linear layers and leaky ReLUs.
    """
    linears = linears_of(networks[0])
    for layer in (layer for network in networks for layer in network):
        if not isinstance(layer, nn.Linear | nn.LeakyReLU):
            raise ValueError(f"found {type(layer).__name__}, expected linear layers and LeakyReLU")
    slopes = {layer.negative_slope for layer in networks[0] if isinstance(layer, nn.LeakyReLU)}
    inputs = max(linears_of(network)[0].in_features for network in networks)
    return Shape(
        ensemble=len(networks),
        widths=(inputs, *(linear.out_features for linear in linears[:-1])),
        outputs=linears[-1].out_features,
        slope=slopes.pop() if slopes else 0.0,
    )


def linears_of(network: nn.Sequential) -> list[nn.Linear]:
    """A perceptron's linear layers."""
    return [layer for layer in network if isinstance(layer, nn.Linear)]
