"""Trials of recurrent policies wait for their training."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lfr.evaluation import trials
from lfr.evaluation.trials import SHARD, Trial
from lfr.scenarios import Scenario
from lfr.seeds import use_of_seed
from lfr.sim.steps import Steps
from lfr.skills.saved_models import Seen
from studies import imitation_trials
from studies.imitation.cloning import ImitationJob
from studies.imitation.saved_policies import save_policy
from studies.imitation_trials import RecurrentPolicyFiles, train_and_judge
from tests.made_up_policies import Line
from tests.studies.imitation.made_up import SMALL, network

SCENARIO = Scenario("s1", ("pick_place", "nut_assembly"), {"panda": "lift", "sawyer": "stack"})


def test_policies_are_judged_after_their_training_by_seed_and_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    line = Line()
    trained: list[int] = []

    def fit(job: ImitationJob) -> dict[str, int]:
        save_policy(Path(job.folder), network(), Seen("sawyer", (), {}, job.seed))
        trained.append(job.seed)
        return {"updates": job.seed}

    class Judged:
        """Sawyer is there in one step, Panda never moves that far."""

        def __init__(self, robot: str) -> None:
            self.task, self.layout, self.horizon, self.robot = None, None, 8, robot

        def reset(self, seed: int) -> np.ndarray:
            assert trained
            line.seeds.append(seed)
            line.at = 0.0
            return np.zeros(3)

        def step(self, actions: np.ndarray, stop_on_success: bool = False) -> Steps:
            line.at = 11.0 if self.robot == "sawyer" else 0.0
            steps = line.step(np.ones(len(actions)), stop_on_success)
            return replace(steps, observations=np.zeros((len(steps), 3)))

    monkeypatch.setattr(imitation_trials, "fit_imitation", fit)
    monkeypatch.setattr(trials, "judge_named", lambda name, robot, task: Judged(robot))
    monkeypatch.setenv("RAY_ADDRESS", "")
    monkeypatch.setattr("os.cpu_count", lambda: 1)  # the patches are this process's alone
    folders = {seed: str(tmp_path / f"seed-{seed}") for seed in (3, 1)}
    policies = {
        seed: ImitationJob(SCENARIO, "sawyer", "lift", SMALL, 0.1, seed, folder, "data")
        for seed, folder in folders.items()
    }
    judged = {
        (seed, robot): Trial(RecurrentPolicyFiles(folder), robot, "lift", episodes)
        for seed, folder in folders.items()
        for robot, episodes in (("panda", 2), ("sawyer", SHARD + 2))
    }
    fitted, found = train_and_judge(policies, judged, tmp_path / "work", "test")
    assert fitted == {3: {"updates": 3}, 1: {"updates": 1}}
    assert list(found) == list(judged)
    counts = {name: (one["successes"], one["episodes"]) for name, one in found.items()}
    assert counts[3, "panda"] == counts[1, "panda"] == (0, 2)
    assert counts[3, "sawyer"] == counts[1, "sawyer"] == (SHARD + 2, SHARD + 2)
    assert {use_of_seed(seed) for seed in line.seeds} == {"held-out"}
