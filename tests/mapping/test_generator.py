"""Eq. 4 by autograd, and what G and F are on disk."""

from pathlib import Path

import pytest
import torch

from lfr.errors import DataError
from lfr.mapping.generator import Generator
from lfr.mapping.generator_pair import GeneratorPair
from lfr.mapping.saved_generators import (
    MappingSeen,
    load_generator,
    load_mapping_seen,
    save_generator,
)
from lfr.skills.vae import LOG_SIGMA_RANGE

Z = 3

SKILLS = "sawyer/lift+stack", "panda/lift"


def pair() -> tuple[Generator, Generator, torch.Tensor, torch.Tensor]:
    torch.manual_seed(0)
    g, f = Generator(Z, 16, 3), Generator(Z, 16, 3)
    k_x, k_y = torch.randn(12, 2 * Z), 0.5 + 2.0 * torch.randn(12, 2 * Z)
    g.fit_scales(k_x, k_y)
    f.fit_scales(k_y, k_x)
    return g, f, k_x, k_y


def l1(a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
    return (a - b).abs().sum(dim=1).mean()


@pytest.mark.parametrize("weight", [0.0, 0.7])
def test_the_gradient_of_eq_4(weight: float) -> None:
    g, f, k_x, k_y = pair()
    to_y, to_x = g.translate(k_x), f.translate(k_y)
    regression = l1(k_x, to_x) + l1(k_y, to_y)  # Eq. 5
    cycle = l1(f.translate(to_y), k_x) + l1(g.translate(to_x), k_y)  # Eq. 6
    parameters = [*g.parameters(), *f.parameters()]
    expected = torch.autograd.grad(regression + weight * cycle, parameters)  # Eq. 4
    both = GeneratorPair(g, f)
    both.networks.vector.copy_(both.gradient(both.standardised(k_x, k_y), weight))
    both.networks.write_back()  # the gradient, read as parameters
    for found, wanted in zip(parameters, expected, strict=True):
        torch.testing.assert_close(found.detach(), wanted, rtol=1e-4, atol=1e-5)


def test_a_generator_maps_mean_and_spread() -> None:
    g, _, k_x, _ = pair()
    mu, log_sigma = g(k_x[:, :Z], k_x[:, Z:])
    together = g.translate(k_x)
    assert torch.equal(mu, together[:, :Z])
    assert torch.equal(log_sigma, together[:, Z:].clamp(*LOG_SIGMA_RANGE))


def test_saved_generators_come_back_identical(tmp_path: Path) -> None:
    g, _, k_x, _ = pair()
    seen = MappingSeen("t", "sawyer", "panda", SKILLS, ("lift",), {"panda-lift": "ab"}, 3)
    save_generator(tmp_path / "g", g, seen)
    assert torch.equal(load_generator(tmp_path / "g").translate(k_x), g.translate(k_x))
    assert load_mapping_seen(tmp_path / "g") == seen


def test_a_damaged_generator_is_named(tmp_path: Path) -> None:
    g, _, _, _ = pair()
    seen = MappingSeen("t", "sawyer", "panda", SKILLS, ("lift",), {}, 3)
    save_generator(tmp_path / "g", g, seen)
    file = tmp_path / "g" / "model.safetensors"
    file.write_bytes(file.read_bytes()[:100])
    with pytest.raises(DataError, match=r"cut off.*g/model\.safetensors"):
        load_generator(tmp_path / "g")
