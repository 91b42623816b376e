"""Trials cut into shards, and rollouts judged, on an arm that is one number."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from lfr.evaluation import trials
from lfr.evaluation.rollouts import Outcome, roll_out
from lfr.evaluation.trials import SHARD, Trial, shards_of, success_rates, summary
from lfr.seeds import use_of_seed
from lfr.sim.steps import Steps


class Line:
    """Starts at seed % 10 and moves by the sum of the actions; success from 12 on."""

    task = layout = None
    horizon = 8

    def __init__(self) -> None:
        self.seeds: list[int] = []

    def reset(self, seed: int) -> np.ndarray:
        self.seeds.append(seed)
        self.at = float(seed % 10)
        return np.array([self.at])

    def step(self, actions: np.ndarray, stop_on_success: bool = False) -> Steps:
        rows = []
        for action in actions:
            self.at += float(action)
            rows.append(self.at)
            if stop_on_success and self.at >= 12:
                break
        at = np.array(rows)
        return Steps(at[:, None], at, at >= 12, bool((at > 1000).any()))


@dataclass(frozen=True)
class Steady:
    """Moves by ``speed`` in each of the three control steps of a skill."""

    speed: float

    def load(self) -> Steady:
        return self

    def act(self, observation: np.ndarray) -> np.ndarray:
        return np.full(3, self.speed)


def test_success_at_any_step_within_the_horizon_and_when() -> None:
    outcomes = roll_out(Steady(1.0), Line(), [4, 3, 9])  # type: ignore[arg-type]
    assert outcomes == [Outcome(4, True, 8), Outcome(3, False, 8), Outcome(9, True, 3)]


def test_diverged_is_no_success() -> None:
    assert roll_out(Steady(2000.0), Line(), [0]) == [Outcome(0, False, 1)]  # type: ignore[arg-type]


def test_shards_cover_the_trial_once() -> None:
    trial = Trial(Steady(1.0), "panda", "lift", episodes=2 * SHARD + 3, first=7)
    shards = shards_of(trial)
    covered = [shard.first + i for shard in shards for i in range(shard.episodes)]
    assert covered == list(range(7, 7 + 2 * SHARD + 3))
    assert max(shard.episodes for shard in shards) == SHARD


def test_rates_are_of_held_out_starts_and_shards_do_not_matter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    line = Line()
    monkeypatch.setattr(trials, "judge_named", lambda *_: line)
    monkeypatch.setenv("RAY_ADDRESS", "")
    monkeypatch.setattr("os.cpu_count", lambda: 1)  # the patches are this process's alone
    asked = {
        "fast": Trial(Steady(3.0), "panda", "lift", 30),
        "slow": Trial(Steady(1.0), "panda", "lift", 30),
    }
    rates = success_rates(asked, tmp_path, "test")
    assert rates["fast"]["rate"] == 1.0
    assert rates["slow"]["rate"] == 0.6  # from 4 to 9 of each ten
    assert rates["slow"]["episodes"] == 30
    assert {use_of_seed(seed) for seed in line.seeds} == {"held-out"}
    assert len(set(line.seeds)) == 30
    again = success_rates(asked, tmp_path, "test")
    assert again == rates
    assert len(line.seeds) == 60  # nothing was run again


def test_summary_of_no_success() -> None:
    found = summary([Outcome(0, False, 8), Outcome(1, False, 8)])
    assert (found["rate"], found["steps"], found["episodes"]) == (0.0, None, 2)
