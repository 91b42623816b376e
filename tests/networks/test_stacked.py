"""Networks of torch.nn as one ensemble: what they answer, their gradients, what is clipped."""

import copy

import pytest
import torch
from torch import Tensor, nn

from lfr.networks.stacked import Stacked


def networks(*inputs: int) -> list[nn.Sequential]:
    torch.manual_seed(0)
    return [
        nn.Sequential(nn.Linear(n, 8), nn.LeakyReLU(0.2), nn.Linear(8, 8), nn.LeakyReLU(0.2),
                      nn.Linear(8, 3))
        for n in inputs
    ]  # fmt: skip


def as_networks(stacked: Stacked, vector: Tensor) -> list[Tensor]:
    """A vector of the ensemble's, network by network, (P_e,) each."""
    held = stacked.vector.clone()
    stacked.vector.copy_(vector)
    stacked.write_back()
    found = [
        nn.utils.parameters_to_vector(network.parameters()).detach().clone()
        for network in stacked._networks
    ]
    stacked.vector.copy_(held)
    stacked.write_back()
    return found


@pytest.mark.parametrize("inputs", [(4,), (4, 6, 5)])
def test_answers_and_gradients_are_those_of_each_network(inputs: tuple[int, ...]) -> None:
    every = networks(*inputs)
    stacked = Stacked(copy.deepcopy(every))
    rows = [torch.randn(7, n, requires_grad=True) for n in inputs]
    answers, traces = stacked.evaluate(stacked.together([row.detach() for row in rows]))
    slopes = torch.randn(len(inputs), 7, 3)
    gradient, by_inputs = stacked.by_parameters_and_inputs(traces, slopes)
    gradient = gradient.clone()  # the next call writes over it
    assert torch.equal(gradient, stacked.by_parameters(traces, slopes))
    parts = as_networks(stacked, gradient)
    for e, network in enumerate(every):
        torch.testing.assert_close(answers[e], network(rows[e]))
        wanted = torch.autograd.grad(network(rows[e]), [rows[e], *network.parameters()], slopes[e])
        torch.testing.assert_close(by_inputs[e, :, : inputs[e]], wanted[0])
        torch.testing.assert_close(parts[e], torch.cat([w.reshape(-1) for w in wanted[1:]]))


def test_only_a_network_whose_gradient_is_too_long_is_clipped() -> None:
    stacked = Stacked(networks(4, 6, 5))
    slopes = torch.randn(3, 7, 3)
    slopes[1] *= 100.0
    _, traces = stacked.evaluate(torch.randn(3, 7, 6))
    lengths = []
    for limit in (float("inf"), 50.0):
        gradient = stacked.clipped(stacked.by_parameters(traces, slopes).clone(), limit)
        parts = as_networks(stacked, gradient)
        lengths.append([float(part.norm()) for part in parts])
    whole, clipped = lengths
    # Weights of inputs that the narrower networks do not have count in the ensemble alone.
    assert whole[1] > 50.0 > max(whole[0], whole[2])
    assert clipped == pytest.approx([whole[0], 50.0, whole[2]], rel=1e-4)
