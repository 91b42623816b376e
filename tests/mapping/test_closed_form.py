"""Maps that need no descent, held to the algebra that they come from."""

from pathlib import Path

import torch
from torch import Tensor

from lfr.mapping.closed_form import constant, linear
from lfr.mapping.mapping_training import Pairs
from lfr.mapping.saved_generators import MappingSeen, load_generator, save_generator

Z = 3


def drawn(*shape: int, seed: int) -> Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed))


def test_linear_recovers_an_affine_map() -> None:
    weight, bias = drawn(2 * Z, 2 * Z, seed=3), drawn(2 * Z, seed=4)
    k_x = drawn(500, 2 * Z, seed=5)
    g = linear(Pairs(k_x, k_x @ weight.T + bias))
    other = 3.0 * drawn(50, 2 * Z, seed=6) + 5.0  # far from where it was fitted
    assert torch.allclose(g.translate(other), other @ weight.T + bias, atol=1e-3)


def test_linear_errs_least_among_linear_maps() -> None:
    k_x = drawn(400, 2 * Z, seed=3)
    k_y = torch.tanh(k_x) + 0.1 * drawn(400, 2 * Z, seed=4)
    g = linear(Pairs(k_x, k_y))
    error = (g.translate(k_x) - k_y).detach()
    # The normal equations: what is left over is orthogonal to what it was told, and to 1.
    assert torch.allclose(k_x.T @ error / 400, torch.zeros(2 * Z, 2 * Z), atol=1e-4)
    assert torch.allclose(error.mean(0), torch.zeros(2 * Z), atol=1e-4)


def test_constant_ignores_its_input() -> None:
    k_x, k_y = drawn(400, 2 * Z, seed=3), drawn(400, 2 * Z, seed=4) + 2.0
    g = constant(Pairs(k_x, k_y))
    answers = g.translate(100.0 * drawn(5, 2 * Z, seed=5))
    assert torch.allclose(answers, k_y.mean(0).expand(5, -1), atol=1e-5)


def test_a_closed_form_map_is_saved_as_a_generator(tmp_path: Path) -> None:
    k_x = drawn(100, 2 * Z, seed=3)
    g = linear(Pairs(k_x, 2.0 * k_x))
    save_generator(
        tmp_path / "g", g, MappingSeen("t", "a", "b", ("a/lift", "b/lift"), ("lift",), {}, 0)
    )
    loaded = load_generator(tmp_path / "g")
    assert torch.equal(loaded.translate(k_x), g.translate(k_x))
