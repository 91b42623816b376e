"""Eq. 4 to 6 in NumPy, and what G and F are on disk."""

from pathlib import Path

import numpy as np
import pytest
import torch

from lfr.errors import DataError
from lfr.mapping.generator import Generator
from lfr.mapping.losses import cycle_loss, mapping_loss, regression_loss
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


def l1(a: torch.Tensor, b: torch.Tensor) -> float:
    return float(np.abs(a.detach().numpy() - b.detach().numpy()).sum(axis=1).mean())


@torch.no_grad()
def test_losses_in_numpy() -> None:
    g, f, k_x, k_y = pair()
    to_y, to_x = g.translate(k_x), f.translate(k_y)
    regression = l1(k_x, to_x) + l1(k_y, to_y)  # Eq. 5
    cycle = l1(f.translate(to_y), k_x) + l1(g.translate(to_x), k_y)  # Eq. 6
    assert float(regression_loss(g, f, k_x, k_y)) == pytest.approx(regression, rel=1e-5)
    assert float(cycle_loss(g, f, k_x, k_y)) == pytest.approx(cycle, rel=1e-5)
    total = float(mapping_loss(g, f, k_x, k_y, 0.7))  # Eq. 4
    assert total == pytest.approx(regression + 0.7 * cycle, rel=1e-5)
    assert float(mapping_loss(g, f, k_x, k_y, 0.0)) == pytest.approx(regression, rel=1e-5)


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
