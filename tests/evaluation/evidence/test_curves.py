"""Area, first steps and alignment of learning curves, by hand and as properties."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lfr.errors import DataError
from lfr.evaluation.evidence.curves import Curve, median_first, read_curves, side_by_side

CURVES = st.lists(
    st.tuples(st.integers(1, 1000), st.floats(0, 1)), min_size=2, max_size=12
).map(
    lambda points: Curve(
        (0, *np.cumsum([step for step, _ in points[1:]]).tolist()),
        tuple(success for _, success in points),
    )
)  # fmt: skip


def test_area_by_hand() -> None:
    assert Curve((0, 10), (0.0, 1.0)).area == pytest.approx(0.5)
    assert Curve((0, 10, 40), (0.2, 0.6, 1.0)).area == pytest.approx((4 + 24) / 40)


@given(CURVES)
def test_area_is_between_the_lowest_and_the_highest_point(curve: Curve) -> None:
    assert min(curve.success) - 1e-9 <= curve.area <= max(curve.success) + 1e-9


def test_first_steps() -> None:
    curve = Curve((0, 5000, 10_000, 15_000), (0.5, 0.85, 0.4, 0.95))
    assert [curve.first_at(level) for level in (0.5, 0.8, 0.95, 1.0)] == [0, 5000, 15_000, None]


@given(CURVES, st.floats(0, 1))
def test_before_the_first_step_no_point_is_there(curve: Curve, level: float) -> None:
    first = curve.first_at(level)
    before = [success for step, success in zip(curve.env_steps, curve.success, strict=True)
              if first is None or step < first]  # fmt: skip
    assert all(success < level for success in before)


def test_never_is_later_than_any_step() -> None:
    assert median_first([100, None, 300]) == 300
    assert median_first([100, 200, None, None]) is None
    assert median_first([0, 10]) == 5
    assert median_first([None]) is None


def test_curves_are_read_where_the_first_has_points_and_all_go() -> None:
    axis, rates = side_by_side([Curve((0, 10, 20), (0.0, 1.0, 1.0)), Curve((0, 16), (0.0, 0.8))])
    assert axis.tolist() == [0, 10, 16]
    assert rates == pytest.approx(np.array([[0.0, 0.0], [1.0, 0.5], [1.0, 0.8]]))


def test_csv_has_a_curve_for_each_reward_and_seed(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("reward,seed,env_steps,success,kl\nsparse,0,0,0.5,\nsparse,0,9,1.0,2.0\n"
                    "dense,0,0,0.25,\ndense,0,7,0.5,\n")  # fmt: skip
    assert read_curves(path) == {
        ("sparse", 0): Curve((0, 9), (0.5, 1.0)),
        ("dense", 0): Curve((0, 7), (0.25, 0.5)),
    }


@pytest.mark.parametrize(
    "text",
    ["seed,env_steps,success\n0,0,0.5\n",
     "reward,seed,env_steps,success\nsparse,0,0,0.5\n",
     "reward,seed,env_steps,success\nsparse,0,0,0.5\nsparse,0,0,0.5\n"],
    ids=["no reward", "one point", "no rise"],
)  # fmt: skip
def test_what_is_no_curve_is_named(tmp_path: Path, text: str) -> None:
    path = tmp_path / "run.csv"
    path.write_text(text)
    with pytest.raises(DataError, match=r"run\.csv"):
        read_curves(path)
    with pytest.raises(DataError, match="missing"):
        read_curves(tmp_path / "none.csv")
