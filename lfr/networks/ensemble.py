"""E multilayer perceptrons of one shape, computed as one, with their gradient written out.

    x (E, B, in) -> [linear -> layer norm, scale and shift -> leaky ReLU] * hidden
                 -> linear -> (E, B, out)

All parameters are one vector, layer by layer: weight (E, in, out), bias (E, 1, out) and, where the
layer is normalised, scale (E, 1, out) and shift (E, 1, out). The gradient is written straight into
a vector of the same order, which is what the optimiser takes: autograd finds the same numbers, but
records every operation and gathers the gradient from its parts.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn import functional

LAYER_NORM_EPSILON = 1e-5  # nn.LayerNorm's


class Layer(NamedTuple):
    """One layer's parameters, or their gradients: views into a vector (P,)."""

    weight: Tensor  # (E, in, out)
    bias: Tensor  # (E, 1, out)
    scale: Tensor | None = None  # (E, 1, out); None without layer normalisation
    shift: Tensor | None = None  # (E, 1, out)


class Trace(NamedTuple):
    """What the gradient needs of one layer's evaluation."""

    x: Tensor  # the layer's input, (E, B, in)
    linear: Tensor | None = None  # weight and bias applied; what is normalised, (E, B, out)
    normalised: Tensor | None = None  # before scale and shift, (E, B, out)
    mean: Tensor | None = None  # (E, B, 1)
    rstd: Tensor | None = None  # 1 / standard deviation, (E, B, 1)


@dataclass(frozen=True)
class Shape:
    """``ensemble`` networks of ``widths``, from the inputs to the last hidden layer.

    Attributes:
        layer_norm: before every activation.
        outputs: width of the last, linear layer.
        slope: of the activation below zero; 0 is the ReLU.
    """

    ensemble: int
    widths: tuple[int, ...]
    layer_norm: bool = False
    outputs: int = 1
    slope: float = 0.0

    @functools.cached_property
    def sizes(self) -> list[list[tuple[int, ...]]]:
        """The shapes of each layer's tensors, in their order in the vector."""
        found = []
        for inputs, outputs in itertools.pairwise(self.widths):
            row = (self.ensemble, 1, outputs)
            found.append(
                [(self.ensemble, inputs, outputs), row, *([row, row] if self.layer_norm else [])]
            )
        last = (self.ensemble, self.widths[-1], self.outputs), (self.ensemble, 1, self.outputs)
        return [*found, list(last)]

    def layers(self, vector: Tensor) -> list[Layer]:
        """The vector (P,) as layers, of which the last one is only linear."""
        counts = [math.prod(size) for sizes in self.sizes for size in sizes]
        parts = iter(vector.split(counts))
        return [Layer(*(next(parts).view(size) for size in sizes)) for sizes in self.sizes]

    def initial(self) -> Tensor:
        """Parameters (P,), initialised as ``nn.Linear`` and ``nn.LayerNorm`` are."""
        vector = torch.empty(sum(math.prod(size) for sizes in self.sizes for size in sizes))
        for layer in self.layers(vector):
            bound = 1.0 / math.sqrt(layer.weight.shape[1])
            layer.weight.uniform_(-bound, bound)
            layer.bias.uniform_(-bound, bound)
            if layer.scale is not None and layer.shift is not None:
                layer.scale.fill_(1.0)
                layer.shift.zero_()
        return vector


def evaluate(layers: Sequence[Layer], x: Tensor, slope: float = 0.0) -> tuple[Tensor, list[Trace]]:
    """Outputs (E, B, out) for inputs (E, B, in), and the traces that ``differentiate`` takes."""
    traces = []
    for weight, bias, scale, shift in layers[:-1]:
        linear = torch.baddbmm(bias, x, weight)
        if scale is None or shift is None:
            traces.append(Trace(x))
            x = functional.leaky_relu_(linear, slope)
            continue
        normalised, mean, rstd = torch.native_layer_norm(
            linear, linear.shape[2:], *_one_and_zero(linear), LAYER_NORM_EPSILON
        )
        traces.append(Trace(x, linear, normalised, mean, rstd))
        x = functional.leaky_relu_(torch.addcmul(shift, normalised, scale), slope)
    weight, bias, *_ = layers[-1]
    return torch.baddbmm(bias, x, weight), [*traces, Trace(x)]


def differentiate(
    layers: Sequence[Layer],
    traces: Sequence[Trace],
    gradient: Tensor,
    into: Sequence[Layer] | None = None,
    slope: float = 0.0,
    *,
    by_inputs: bool = False,
) -> Tensor | None:
    """The chain rule, from a gradient by the outputs (E, B, out) back through all layers.

    Args:
        into: where the gradient by the parameters is written, if it is wanted.
        by_inputs: whether the gradient by the inputs (E, B, in) is wanted, and returned.
    """
    g = gradient
    for i in range(len(layers) - 1, -1, -1):
        weight, _, scale, _ = layers[i]
        x, linear, normalised, mean, rstd = traces[i]
        if i < len(layers) - 1:
            g = leaky_relu_backward(g, traces[i + 1].x, slope, True)
        if linear is not None and normalised is not None:
            if into is not None:
                torch.sum(g * normalised, 1, keepdim=True, out=into[i].scale)
                torch.sum(g, 1, keepdim=True, out=into[i].shift)
            g = layer_norm_backward(
                g * scale, linear, linear.shape[2:], mean, rstd, None, None, [True, False, False]
            )[0]
        if into is not None:
            _weight_gradient(x, g, into[i].weight)
            torch.sum(g, 1, keepdim=True, out=into[i].bias)
        if i > 0 or by_inputs:
            g = torch.bmm(g, weight.mT)
    return g if by_inputs else None


leaky_relu_backward = torch.ops.aten.leaky_relu_backward.default
layer_norm_backward = torch.ops.aten.native_layer_norm_backward.default


def _weight_gradient(x: Tensor, g: Tensor, out: Tensor) -> None:
    if out.shape[2] == 1:  # as a row, which is twice as fast
        torch.bmm(g.mT, x, out=out.mT)
    else:
        torch.bmm(x.mT, g, out=out)


def _one_and_zero(like: Tensor) -> tuple[Tensor, Tensor]:
    """A scale and a shift (out,) that change nothing; without them the kernel is half as fast."""
    return _constants(like.shape[2], like.dtype, like.device)


@functools.cache
def _constants(size: int, dtype: torch.dtype, device: torch.device) -> tuple[Tensor, Tensor]:
    one = torch.ones(size, dtype=dtype, device=device)
    return one, torch.zeros_like(one)
