"""Dual descent: alpha rises while the divergence is above its target, and falls below it."""

import pytest
import torch

from lfr.networks.optimizer import FlatAdam
from lfr.transfer.temperature import Temperature


@pytest.mark.parametrize(("kl", "rises"), [(5.0, True), (0.5, False)])
def test_alpha_moves_towards_the_constraint(kl, rises):
    temperature = Temperature(0.1)
    adam = FlatAdam(temperature.log_alpha, 1e-2)
    assert temperature().item() == pytest.approx(0.1)
    for _ in range(20):
        adam.descend(temperature.gradient(torch.tensor(kl), 1.5))
    assert (temperature().item() > 0.1) == rises


def test_alpha_rests_at_the_target_and_stays_positive():
    temperature = Temperature(0.1)
    adam = FlatAdam(temperature.log_alpha, 1e-2)
    adam.descend(temperature.gradient(torch.tensor(1.5), 1.5))
    assert temperature().item() == pytest.approx(0.1)
    for _ in range(2000):
        adam.descend(temperature.gradient(torch.tensor(0.0), 10.0))
    assert temperature().item() > 0


def test_the_descent_finds_the_multiplier_of_the_constrained_problem():
    """max_m m - alpha m^2 / 2 has m = 1 / alpha; KL = m^2 / 2 held at 2 wants alpha = 1/2."""
    temperature = Temperature(3.0)
    adam = FlatAdam(temperature.log_alpha, 1e-2)
    for _ in range(1500):
        m = 1.0 / temperature()
        adam.descend(temperature.gradient(m**2 / 2, 2.0))
    assert temperature().item() == pytest.approx(0.5, rel=0.02)
