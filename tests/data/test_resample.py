"""Fewer steps a second, against sums over the frames written out by hand."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from lfr.columns import ActionSpace
from lfr.data.resample import first_frame, frames_of, resampled
from lfr.data.windows import DemonstrationSet

NAMES = ("dx", "gripper")


def demonstrations(lengths: list[int], fps: int) -> DemonstrationSet:
    rng = np.random.default_rng(0)
    rows = sum(lengths)
    return DemonstrationSet(
        observations=torch.arange(rows, dtype=torch.float32)[:, None],
        actions=torch.tensor(rng.uniform(-1, 1, (rows, 2)), dtype=torch.float32),
        rewards=torch.tensor(rng.uniform(0, 1, rows), dtype=torch.float32),
        successes=torch.tensor(rng.uniform(0, 1, rows) > 0.8),
        starts=torch.tensor([0, *np.cumsum(lengths)]),
        observation_names=("number.row",),
        action_space=ActionSpace(NAMES, (-1.0, -1.0), (1.0, 1.0)),
        robot="puck", task="push", fps=fps, seeds=tuple(range(len(lengths))),
    )  # fmt: skip


def frames(length: int, fps: int, rate: int) -> list[list[int]]:
    """Of each step the frames that begin in its time, by exact fractions."""
    steps: dict[int, list[int]] = {}
    for frame in range(length):
        steps.setdefault(int(Fraction(frame, fps) * rate), []).append(frame)
    return [steps[step] for step in sorted(steps)]


@given(
    st.lists(st.integers(1, 70), min_size=1, max_size=4),
    st.sampled_from([(80, 25), (25, 20), (30, 10), (50, 7), (20, 20)]),
)
def test_a_step_is_the_frames_that_begin_in_its_time(
    lengths: list[int], rates: tuple[int, int]
) -> None:
    fps, rate = rates
    whole = demonstrations(lengths, fps)
    found = resampled(whole, rate, ["dx"])
    assert found.fps == rate
    assert found.seeds == whole.seeds
    start, row = 0, 0
    for episode, length in enumerate(lengths):
        assert int(found.starts[episode]) == row
        for step in frames(length, fps, rate):
            rows = [start + frame for frame in step]
            assert found.observations[row] == whole.observations[rows[0]]
            dx, gripper = found.actions[row].tolist()
            assert dx == pytest.approx(whole.actions[rows, 0].mean().item(), abs=1e-6)
            assert gripper == whole.actions[rows[-1], 1].item()
            assert found.rewards is not None
            assert found.successes is not None
            assert whole.rewards is not None
            assert whole.successes is not None
            assert found.rewards[row] == pytest.approx(whole.rewards[rows].sum().item(), rel=1e-5)
            assert found.successes[row] == whole.successes[rows].any()
            row += 1
        start += length
    assert len(found) == row


def test_repeating_the_mean_leads_as_far() -> None:
    whole = demonstrations([67], 80)
    found = resampled(whole, 25, ["dx"])
    lasts = [frames_of(step, 3.2) for step in range(len(found))]
    lasts[-1] -= sum(lasts) - 67  # the last one is cut short
    way = sum(n * dx for n, dx in zip(lasts, found.actions[:, 0].tolist(), strict=True))
    assert way == pytest.approx(whole.actions[:, 0].sum().item(), abs=1e-4)


def test_steps_follow_each_other_without_gaps() -> None:
    for ratio in (1.0, 1.25, 3.2, 50 / 7, 30 / 10):
        begins = [first_frame(step, ratio) for step in range(2000)]
        lasts = [frames_of(step, ratio) for step in range(1999)]
        assert np.array_equal(np.diff(begins), lasts)
        assert min(lasts) >= 1
        assert begins[-1] / 1999 == pytest.approx(ratio, abs=1e-3)


def test_what_cannot_be_is_told() -> None:
    whole = demonstrations([20], 20)
    with pytest.raises(ValueError, match="recorded at 20 a second, so not at 25"):
        resampled(whole, 25, [])
    with pytest.raises(ValueError, match=r"deltas: no dy in the action's dx, gripper"):
        resampled(whole, 10, ["dy"])
    nothing = replace(whole, rewards=None, successes=None)
    assert resampled(nothing, 10, []).rewards is None
