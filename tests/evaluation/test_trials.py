"""Trials cut into shards, and rollouts judged, on an arm that is one number."""

from __future__ import annotations

from pathlib import Path

import pytest

from lfr.evaluation import trials
from lfr.evaluation.trials import SHARD, Trial, shards_of, success_rates, summary
from lfr.policies import Outcome
from lfr.seeds import use_of_seed
from tests.made_up_policies import Line, Steady


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
