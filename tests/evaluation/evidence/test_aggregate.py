"""rliable's definitions, against hand-computed cases and scipy's own statistics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from lfr.evaluation.evidence.aggregate import (
    Seeds,
    bootstrap,
    difference,
    improvement,
    interquartile_mean,
    mean,
    over_seeds,
    probability_of_improvement,
)

MANY = 10**9  # episodes: a rate without noise of its own
RATES = st.lists(st.integers(0, 10).map(lambda tenths: tenths / 10), min_size=1, max_size=9)


def exact(*rates: float) -> Seeds:
    return Seeds(tuple(round(rate * MANY) for rate in rates), (MANY,) * len(rates))


@pytest.mark.parametrize(
    ("rates", "expected"),
    [
        ([0.0, 0.1, 0.5, 0.6, 1.0], 0.4),  # of five, the middle three
        ([1.0, 0.2, 0.4, 0.0], 0.3),  # of four, the middle two
        ([0.0, 0.3, 0.9], 0.4),  # of three, all
        ([0.7], 0.7),
    ],
)
def test_interquartile_mean_by_hand(rates: list[float], expected: float) -> None:
    assert interquartile_mean(np.array(rates)) == pytest.approx(expected)


def test_statistics_are_of_the_last_axis() -> None:
    rates = np.random.default_rng(0).random((2, 3, 5))
    for statistic in (mean, interquartile_mean):
        assert statistic(rates).shape == (2, 3)
        assert statistic(rates)[1, 2] == pytest.approx(statistic(rates[1, 2]))


@pytest.mark.parametrize("statistic", [mean, interquartile_mean])
def test_interval_over_seeds_is_scipys(statistic) -> None:
    rates = np.array([0.1, 0.35, 0.4, 0.8, 0.95])

    def along(values: np.ndarray, axis: int) -> np.ndarray:
        return statistic(np.moveaxis(values, axis, -1))

    drawn = stats.bootstrap((rates,), along, n_resamples=10_000, method="percentile", rng=1)
    expected = drawn.confidence_interval
    found = bootstrap([exact(*rates)], statistic)
    assert found.value == pytest.approx(float(statistic(rates)))
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), abs=0.03)
    _, low, high = over_seeds(np.stack([rates, rates]), statistic)
    assert (low[1], high[1]) == pytest.approx((expected.low, expected.high), abs=0.03)


def test_interval_of_one_seed_is_that_of_its_episodes() -> None:
    found = bootstrap([Seeds((80,), (100,))])
    low, high = stats.binom(100, 0.8).ppf([0.025, 0.975]) / 100
    assert (found.low, found.high) == pytest.approx((low, high), abs=0.011)


def test_episodes_widen_the_interval_of_seeds() -> None:
    few, many = bootstrap([Seeds((4, 5, 6), (10, 10, 10))]), bootstrap([exact(0.4, 0.5, 0.6)])
    assert few.low < many.low < many.high < few.high


def test_each_task_is_resampled_by_itself() -> None:
    """Drawn from both tasks together, the mean would be anything between 0 and 1."""
    found = bootstrap([exact(0.0, 0.0), exact(1.0, 1.0)], mean)
    assert (found.low, found.value, found.high) == pytest.approx((0.5, 0.5, 0.5), abs=1e-4)


@pytest.mark.parametrize("successes", [0, 100])
def test_all_alike_is_no_certainty(successes: int) -> None:
    """Of the starts, which both seeds meet: not of twice as many."""
    found = bootstrap([Seeds((successes, successes), (100, 100))])
    wilson = stats.binomtest(successes, 100).proportion_ci(method="wilson")
    assert (found.low, found.high) == pytest.approx((wilson.low, wilson.high), abs=1e-12)


def test_no_interval_is_narrower_than_that_of_its_starts() -> None:
    """One failure in 500: the middle three seeds of nearly every resample have none."""
    found = bootstrap([Seeds((100, 100, 100, 100, 99), (100,) * 5)])
    wilson = stats.binomtest(100, 100).proportion_ci(method="wilson")  # of the IQM's value, 1
    assert found.value == 1.0
    assert found.low <= wilson.low + 1e-12
    worse = bootstrap([Seeds((100, 100, 99, 99, 99), (100,) * 5)])
    assert worse.high >= found.low  # 499 and 497 of 500 are not told apart


def test_seeds_that_fail_at_the_same_starts_are_covered() -> None:
    """Each start succeeds always or never, whoever tries: 100 of them say as much as one seed."""
    generator, rate = np.random.default_rng(3), 0.9
    held = 0
    for _ in range(200):
        successes = int(generator.binomial(100, rate))
        found = bootstrap([Seeds((successes,) * 5, (100,) * 5)], resamples=200)
        held += found.low <= rate <= found.high
    assert held >= 0.9 * 200


def test_difference_of_means_is_scipys() -> None:
    """Of many episodes, so that the seeds alone vary; a shift of all tasks moves it as far."""
    x, y = (0.5, 0.6, 0.9, 0.7, 0.8), (0.4, 0.1, 0.3, 0.2, 0.6)
    expected = stats.bootstrap(
        (x, y), lambda a, b, axis: np.mean(a, axis) - np.mean(b, axis), method="percentile",
        n_resamples=10_000, rng=np.random.default_rng(1),
    ).confidence_interval  # fmt: skip
    found = difference([exact(*x)], [exact(*y)])
    assert found.value == pytest.approx(np.mean(x) - np.mean(y))
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), abs=0.02)
    both = difference([exact(*x), exact(0.5)], [exact(*y), exact(0.5)])
    assert both.value == pytest.approx(found.value * 5 / 6)
    assert difference([exact(*y)], [exact(*x)]).value == pytest.approx(-found.value)


@settings(max_examples=30)
@given(st.lists(st.integers(0, 20), min_size=1, max_size=6))
def test_interval_is_ordered_within_bounds_and_the_same_again(successes: list[int]) -> None:
    seeds = Seeds(tuple(successes), (20,) * len(successes))
    found = bootstrap([seeds], resamples=200)
    assert 0.0 <= found.low <= found.high <= 1.0
    assert found == bootstrap([seeds], resamples=200)


@given(RATES, RATES)
def test_probability_of_improvement_is_mann_whitneys(x: list[float], y: list[float]) -> None:
    expected = stats.mannwhitneyu(x, y, alternative="greater").statistic / (len(x) * len(y))
    found = probability_of_improvement([np.array(x)], [np.array(y)])
    assert found == pytest.approx(expected)
    assert found + probability_of_improvement([np.array(y)], [np.array(x)]) == pytest.approx(1.0)


def test_improvement_by_hand() -> None:
    """Of 2 x 2 pairs two are won and two are lost; on the second task all are won."""
    x, y = [exact(0.5, 0.5), exact(0.9, 0.9)], [exact(0.4, 0.6), exact(0.1, 0.2)]
    assert improvement(x[:1], y[:1]).value == pytest.approx(0.5)
    assert improvement(x, y).value == pytest.approx(0.75)
    ties = improvement([exact(0.5, 0.6)], [exact(0.5)])
    assert ties.value == pytest.approx(0.75)
    assert (ties.low, ties.high) == (0.5, 1.0)
    won = improvement(x[1:], y[1:])
    assert (won.low, won.value, won.high) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize(("successes", "episodes"), [((), ()), ((3,), (2,)), ((1, 2), (5,))])
def test_impossible_counts(successes: tuple[int, ...], episodes: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"seeds|episodes"):
        Seeds(successes, episodes)
