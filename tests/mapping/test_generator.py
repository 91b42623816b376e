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
from lfr.skills.gaussian import LOG_SIGMA_RANGE
from lfr.spaces import ROBOT_STATE

Z = 3

SKILLS = "sawyer/lift+stack", "panda/lift"


def states(count: int) -> torch.Tensor:
    return torch.randn(count, ROBOT_STATE.size, generator=torch.Generator().manual_seed(5))


def pair(
    names: tuple[str, ...] = (),
) -> tuple[Generator, Generator, torch.Tensor, torch.Tensor]:
    torch.manual_seed(0)
    g, f = (Generator(Z, 16, 3, names, turned=bool(names)) for _ in range(2))
    k_x, k_y = torch.randn(12, 2 * Z), 0.5 + 2.0 * torch.randn(12, 2 * Z)
    g.fit_scales(k_x, k_y, states(12))
    f.fit_scales(k_y, k_x, states(12))
    return g, f, k_x, k_y


def l1(a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
    return (a - b).abs().sum(dim=1).mean()


@pytest.mark.parametrize("names", [(), ROBOT_STATE.names], ids=["G(k)", "G(k, s)"])
@pytest.mark.parametrize("weight", [0.0, 0.7])
def test_the_gradient_of_eq_4(weight: float, names: tuple[str, ...]) -> None:
    g, f, k_x, k_y = pair(names)
    seen = g.features(states(len(k_x)))
    to_y, to_x = g.translate(k_x, seen), f.translate(k_y, seen)
    regression = l1(k_x, to_x) + l1(k_y, to_y)  # Eq. 5
    cycle = l1(f.translate(to_y, seen), k_x) + l1(g.translate(to_x, seen), k_y)  # Eq. 6
    parameters = [*g.parameters(), *f.parameters()]
    expected = torch.autograd.grad(regression + weight * cycle, parameters)  # Eq. 4
    both = GeneratorPair(g, f)
    both.networks.vector.copy_(both.gradient(both.standardised(k_x, k_y), weight, seen))
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


def test_what_g_sees_of_the_state_is_saved_and_the_task_is_not_seen(tmp_path: Path) -> None:
    g, _, k_x, _ = pair(ROBOT_STATE.names)
    seen = MappingSeen("t", "sawyer", "panda", SKILLS, ("lift",), {}, 3)
    save_generator(tmp_path / "g", g, seen)
    loaded, k = load_generator(tmp_path / "g"), k_x.chunk(2, dim=-1)
    assert (loaded.state_names, loaded.turned) == (ROBOT_STATE.names, True)
    task = torch.randn(12, 4)
    observations = torch.cat([states(12), task], dim=-1)
    first = loaded.at(*k, observations)
    assert all(torch.equal(a, b) for a, b in zip(first, g.at(*k, observations), strict=True))
    elsewhere = torch.cat([states(12), task + 1.0], dim=-1)
    assert torch.equal(loaded.at(*k, elsewhere)[0], first[0])
    other = torch.cat([states(12).flip(0), task], dim=-1)
    assert not torch.allclose(loaded.at(*k, other)[0], first[0], atol=1e-2)
