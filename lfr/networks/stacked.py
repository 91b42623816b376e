"""Perceptrons of ``torch.nn`` as one ensemble while they are trained."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

from lfr.networks.device import CPU
from lfr.networks.ensemble import Trace, differentiate, evaluate
from lfr.networks.perceptron import linears_of, shape_of


class Stacked:
    """E sequences of linear layers and leaky ReLUs, alike but for the number of their inputs.

    Inputs are filled up with zeros to the widest; the weights of these learn nothing. The networks
    themselves stay as they are until `write_back`.

    Args:
        device: of the ensemble, whatever that of the networks.

    Attributes:
        vector: all parameters (P,); a change in place is a change of the ensemble.
    """

    def __init__(self, networks: Sequence[nn.Sequential], device: torch.device = CPU) -> None:
        self._networks = list(networks)
        self._shape = shape_of(networks)
        self.inputs, self._slope = self._shape.widths[0], self._shape.slope
        self.vector = self._shape.initial().to(device)
        self._gradients = torch.zeros_like(self.vector)
        self._layers, self._slopes = (
            self._shape.layers(vector) for vector in (self.vector, self._gradients)
        )
        with torch.no_grad():
            for member, network in enumerate(networks):
                for linear, layer in zip(linears_of(network), self._layers, strict=True):
                    layer.weight[member].zero_()[: linear.in_features] = linear.weight.T
                    layer.bias[member, 0] = linear.bias

    def together(self, inputs: Sequence[Tensor]) -> Tensor:
        """The inputs (..., in) of each network as (E, ..., in of the widest)."""
        widths = (self.inputs - one.shape[-1] for one in inputs)
        return torch.stack(
            [functional.pad(one, (0, width)) for one, width in zip(inputs, widths, strict=True)]
        )

    @torch.no_grad()
    def evaluate(self, inputs: Tensor) -> tuple[Tensor, list[Trace]]:
        """Outputs (E, B, out) for inputs (E, B, in), and how they came about."""
        return evaluate(self._layers, inputs, self._slope)

    @torch.no_grad()
    def by_parameters(self, traces: list[Trace], by_outputs: Tensor) -> Tensor:
        """dL/dvector (P,) for dL/doutputs (E, B, out); overwritten by the next call."""
        differentiate(self._layers, traces, by_outputs, self._slopes, self._slope)
        return self._gradients

    @torch.no_grad()
    def by_parameters_and_inputs(
        self, traces: list[Trace], by_outputs: Tensor
    ) -> tuple[Tensor, Tensor]:
        """As `by_parameters`, and dL/dinputs (E, B, in)."""
        by_inputs = differentiate(
            self._layers, traces, by_outputs, self._slopes, self._slope, by_inputs=True
        )
        assert by_inputs is not None
        return self._gradients, by_inputs

    def clipped(self, gradient: Tensor, limit: float) -> Tensor:
        """A gradient (P,), each network's part scaled in place to a norm of at most ``limit``."""
        if float(torch.linalg.vector_norm(gradient)) > limit:
            tensors = [t for layer in self._shape.layers(gradient) for t in layer if t is not None]
            for member in range(self._shape.ensemble):
                parts = [tensor[member] for tensor in tensors]
                norm = float(torch.stack([part.square().sum() for part in parts]).sum().sqrt())
                for part in parts if norm > limit else []:
                    part.mul_(limit / norm)
        return gradient

    @torch.no_grad()
    def write_back(self) -> None:
        """Give the networks the parameters that they have here by now."""
        for member, network in enumerate(self._networks):
            for linear, layer in zip(linears_of(network), self._layers, strict=True):
                linear.weight.copy_(layer.weight[member, : linear.in_features].T)
                linear.bias.copy_(layer.bias[member, 0])
