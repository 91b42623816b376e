"""Networks of torch.nn that learn in one vector, against autograd on copies of them."""

import copy
import itertools

import pytest
import torch
from torch import Tensor, nn

from lfr.networks.perceptron import perceptrons


def network(*widths: int) -> nn.Sequential:
    layers: list[nn.Module] = []
    for inputs, outputs in itertools.pairwise(widths[:-1]):
        layers += [nn.Linear(inputs, outputs), nn.LeakyReLU(0.2)]
    return nn.Sequential(*layers, nn.Linear(widths[-2], widths[-1])).double()


def in_vector(parameters: list[Tensor]) -> Tensor:
    """Weights and biases as the vector has them: (in, out) each, layer by layer."""
    return torch.cat([p.detach().t().reshape(-1) for p in parameters])


@pytest.mark.parametrize("widths", [(4, 3), (4, 8, 3), (4, 8, 8, 1)])
@pytest.mark.parametrize("learns", [True, False])
def test_answers_and_gradients_are_autograds(widths: tuple[int, ...], learns: bool) -> None:
    torch.manual_seed(0)
    own = network(*widths)
    reference = copy.deepcopy(own)
    _, gradient, (perceptron,) = perceptrons([own])
    x, slopes = torch.randn(7, 4).double().requires_grad_(), torch.randn(7, widths[-1]).double()
    answers = reference(x)
    wanted = torch.autograd.grad(answers, [x, *reference.parameters()], slopes)
    found, traces = perceptron.evaluate(x.detach())
    torch.testing.assert_close(found, answers.detach(), rtol=1e-12, atol=1e-12)
    by_x = perceptron.differentiate(traces, slopes, learns=learns, by_x=True)
    torch.testing.assert_close(by_x, wanted[0], rtol=1e-10, atol=1e-10)
    expected = in_vector(list(wanted[1:])) if learns else torch.zeros_like(gradient)
    torch.testing.assert_close(gradient, expected, rtol=1e-10, atol=1e-10)
    assert perceptron.differentiate(traces, slopes) is None


def test_what_is_done_to_the_vector_is_done_to_the_networks() -> None:
    torch.manual_seed(0)
    one, other = network(4, 8, 3), network(5, 2)
    kept = [copy.deepcopy(one), copy.deepcopy(other)]
    vector, _, _ = perceptrons([one, other])
    assert torch.equal(vector, in_vector([*one.parameters(), *other.parameters()]))
    for network_, before in zip((one, other), kept, strict=True):
        for (name, now), was in zip(
            network_.state_dict().items(), before.state_dict().values(), strict=True
        ):
            assert torch.equal(now, was), name
    vector.mul_(2.0)
    first = [each.state_dict()["0.weight"] for each in (kept[0], kept[1], other)]
    assert torch.equal(first[2], 2.0 * first[1])
    one.load_state_dict(kept[0].state_dict())  # which copies into the views
    assert torch.equal(vector[: 4 * 8], first[0].t().reshape(-1))


def test_what_has_no_gradient_here_is_refused() -> None:
    with pytest.raises(ValueError, match="found SiLU"):
        perceptrons([nn.Sequential(nn.Linear(3, 4), nn.SiLU(), nn.Linear(4, 2))])
