"""What a learning run writes down of itself, undisturbed and killed."""

from __future__ import annotations

import csv
import dataclasses
from pathlib import Path

import pytest
import torch

from lfr.artifacts import file_hash
from lfr.skills.vae import SkillVAE
from lfr.transfer.log import LearningLog
from lfr.transfer.loop import TransferLoop
from lfr.transfer.model import load_policy
from lfr.transfer.transfer_params import TransferParams

from .point import Models, PointSimulation, lfr_initialization


class Killed(Exception):
    """What stands for a signal, so that the run ends within this process."""


class Killing(LearningLog):
    """Ends the run at ``at`` environment steps, after a row that is cut off."""

    at = 1_000_000

    def on_progress(self, env_steps: int, total: int) -> None:
        super().on_progress(env_steps, total)
        if env_steps >= self.at:
            with (self.folder / "updates.csv").open("a") as stream:
                stream.write("1")
            raise Killed


@pytest.fixture
def models(artifacts: Models) -> Models:
    torch.manual_seed(0)
    decoder = SkillVAE(horizon=3, action_dim=2, latent_dim=2, hidden=8)  # one that can be saved
    return artifacts._replace(target_vae=decoder)


def learn(models: Models, params: TransferParams, out: Path, killed_at: int | None = None):
    """A run with its log in ``out``/log and its checkpoints in ``out``/work."""
    start = lfr_initialization(models, params)
    log = Killing(out / "log", start.actor, {"seed": 0, "method": "lfr"})
    log.at = Killing.at if killed_at is None else killed_at
    simulations = [PointSimulation() for _ in range(params.simulations)]
    loop = TransferLoop(start, simulations, params, 0, out / "work", log)
    loop.run()
    return loop


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_the_curve_the_updates_and_the_policies(
    models: Models, params: TransferParams, tmp_path: Path
) -> None:
    loop = learn(models, params, tmp_path)
    log = tmp_path / "log"
    curve = [{k: "" if v is None else str(v) for k, v in dataclasses.asdict(point).items()}
             for point in loop.curve]  # fmt: skip
    assert rows(log / "curve.csv") == curve
    updates = rows(log / "updates.csv")
    assert int(updates[-1]["updates"]) == loop.progress.updates
    assert all(row["critic_loss"] for row in updates)
    assert [row["kl"] for row in updates if int(row["env_steps"]) < params.warm_up] == []
    kept = {path.name: load_policy(path)[1] for path in log.glob("policy-*")}
    steps = [point.env_steps for point in loop.curve]
    assert sorted(kept) == [f"policy-{at:06d}" for at in steps]  # at the start, half-way, the end
    assert sorted(about["env_steps"] for about in kept.values()) == steps
    assert all(about["method"] == "lfr" for about in kept.values())


@pytest.mark.parametrize("killed_at", [10, 45, 80, 110])
def test_a_run_that_was_killed_leaves_the_same(
    models: Models, params: TransferParams, tmp_path: Path, killed_at: int
) -> None:
    params = dataclasses.replace(params, evaluate_every=20)
    learn(models, params, tmp_path / "whole")
    with pytest.raises(Killed):
        learn(models, params, tmp_path / "killed", killed_at)
    learn(models, params, tmp_path / "killed")
    assert file_hash(tmp_path / "killed/log") == file_hash(tmp_path / "whole/log")
