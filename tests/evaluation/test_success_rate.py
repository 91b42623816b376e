"""Wilson intervals against scipy's."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from lfr.evaluation.success_rate import success_of, wilson_interval


@given(st.integers(1, 500).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))),
       st.sampled_from([0.8, 0.95, 0.99]))  # fmt: skip
def test_wilson_interval_is_scipys(counts: tuple[int, int], confidence: float) -> None:
    successes, episodes = counts
    expected = binomtest(successes, episodes).proportion_ci(confidence, method="wilson")
    found = wilson_interval(successes, episodes, confidence)
    assert found == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_the_figures_of_the_field_notes() -> None:
    """27 of 30 is 74 to 97 %; 180 of 200 is 85 to 93 %."""
    small, large = success_of(27, 30), success_of(180, 200)
    assert (round(small.low, 2), round(small.high, 2)) == (0.74, 0.97)
    assert (round(large.low, 2), round(large.high, 2)) == (0.85, 0.93)
    assert small.rate == large.rate == 0.9


def test_the_interval_ends_exactly_at_nothing_and_everything() -> None:
    assert success_of(0, 20).low == 0.0 < success_of(0, 20).high
    assert success_of(20, 20).low < success_of(20, 20).high == 1.0


@pytest.mark.parametrize(("successes", "episodes"), [(3, 2), (-1, 2), (0, 0)])
def test_impossible_counts(successes: int, episodes: int) -> None:
    with pytest.raises(ValueError, match="episodes"):
        success_of(successes, episodes)
