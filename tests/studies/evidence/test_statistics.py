"""Intervals against closed forms, SciPy's bootstrap, and repetitions with a known truth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import bootstrap

from lfr.evaluation.success_rate import wilson_interval
from studies.evidence.statistics import difference, outcomes_of, success


def drawn(rates: np.ndarray, seed: int) -> np.ndarray:
    return (np.random.default_rng(seed).random(rates.shape) < rates).astype(float)


def test_outcomes_are_a_row_for_each_run() -> None:
    np.testing.assert_array_equal(outcomes_of(["101", "001"]), [[1, 0, 1], [0, 0, 1]])


def test_one_seed_is_a_bootstrap_over_starts() -> None:
    apart = drawn(np.full((1, 100), 0.9), 0) - drawn(np.full((1, 100), 0.6), 1)
    found = difference(apart, np.zeros_like(apart))
    expected = bootstrap((apart[0],), np.mean, method="percentile", rng=0).confidence_interval
    assert found.mean == pytest.approx(apart.mean())
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), abs=0.012)


def test_one_rate_is_never_narrower_than_wilsons() -> None:
    assert success(np.ones((5, 100))) == (1.0, *wilson_interval(100, 100))
    assert success(np.zeros((3, 100))) == (0.0, *wilson_interval(0, 100))


def test_seeds_that_differ_widen_it_and_starts_that_differ_too() -> None:
    alike, seeds = np.full((5, 100), 0.5), np.repeat([[0.0], [0.2], [0.5], [0.8], [1.0]], 100, 1)
    starts = np.repeat((np.arange(100) < 50)[None].astype(float), 5, 0)
    widths = [found.high - found.low for found in map(success, (drawn(alike, 0), seeds, starts))]
    # Owen 2007: at least the standard errors of either margin
    assert widths[1] >= 2 * 1.96 * np.std([0, 0.2, 0.5, 0.8, 1]) / math.sqrt(5) * 0.9
    assert widths[2] >= 2 * 1.96 * 0.5 / math.sqrt(100) * 0.9
    assert widths[0] < widths[1]


def test_a_difference_of_paired_starts_is_surer_than_two_rates() -> None:
    hard = np.repeat(np.linspace(0.2, 1.0, 100)[None], 3, 0)
    second = drawn(hard, 0)
    first = np.maximum(second, drawn(np.full((3, 100), 0.4), 1))
    apart, rates = difference(first, second), [success(one) for one in (first, second)]
    assert apart.low > 0.0
    assert rates[0].low < rates[1].high


def test_the_interval_of_a_difference_holds_the_truth() -> None:
    """Seeds and starts with effects of their own: 95 % of intervals, within what 60 can say."""
    held = 0
    for repetition in range(60):
        random = np.random.default_rng(repetition)
        seeds, starts = random.normal(0, 0.05, (5, 1)), random.normal(0, 0.1, (1, 100))
        first = drawn((0.7 + seeds + starts).clip(0, 1), 1000 + repetition)
        second = drawn(np.full((5, 100), 0.5), 3000 + repetition)
        found = difference(first, second)
        held += found.low <= 0.2 <= found.high
    assert held >= 52


def test_other_starts_are_refused() -> None:
    with pytest.raises(ValueError, match="not of the same"):
        difference(np.ones((3, 100)), np.ones((3, 50)))
