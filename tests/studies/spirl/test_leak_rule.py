"""What the prior of any task reads, and what it says that it has read."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import torch

from lfr.columns import ActionSpace
from lfr.data.windows import WindowBatch
from lfr.embodiments import embodiment
from lfr.errors import LfrError
from lfr.scenarios import Scenario, check_visible, transfers_of
from lfr.skills.demonstrations import Demonstrations
from lfr.skills.library import RoleModels, transfer_models
from lfr.skills.skill_params import PriorParams
from lfr.skills.symmetry import SymmetryParams
from lfr.skills.vae import SkillVAE
from lfr.tasks import task as task_named
from studies.spirl import any_task
from studies.spirl.any_task import AnyTaskJob, fit_any_task
from studies.spirl.other_task import load_other_task
from tests.skills.made_up import save_models

SCENARIO = Scenario("s1", ("pick_place", "nut_assembly"), {"panda": "lift", "sawyer": "stack"})
TRANSFER = transfers_of(SCENARIO)[0]  # lift from sawyer to panda
PRIOR = PriorParams(hidden=8, layers=2, steps=2, batch=4, symmetry=SymmetryParams(copies=1))
ACTION_NAMES = embodiment("panda").action.names


def made_up(robot: str, task: str) -> Demonstrations:
    names = task_named(task).observation.names
    actions = ActionSpace(ACTION_NAMES, (-1.0,) * 7, (1.0,) * 7)
    batch = WindowBatch(torch.rand(9, len(names)), torch.rand(9, 4, 7), torch.zeros(9, 4) > 0)
    name = f"{robot}-{task}"
    states = batch.observations
    return Demonstrations(name, f"of {name}", names, actions, batch, batch, states, states)


def target(root: Path) -> RoleModels:
    return transfer_models(SCENARIO, TRANSFER, root)["target"]


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, str, str]]:
    """(role, robot, task) of all that is read; the leak rule stands before it as it does."""
    seen: list[tuple[str, str, str]] = []

    def read_visible(scenario, robot, role, tasks, **_):
        check_visible(scenario, robot, role, tasks)
        seen.extend((role, robot, task) for task in tasks)
        return {task: made_up(robot, task) for task in tasks}

    monkeypatch.setattr(any_task, "read_visible", read_visible)
    return seen


def test_what_is_hidden_is_refused_before_anything_is_read(tmp_path: Path) -> None:
    """A transfer that claims the new task to be common does not get past the rule."""
    claimed = replace(TRANSFER, common=(*TRANSFER.common, "lift"))
    job = AnyTaskJob(SCENARIO, claimed, PRIOR, 0.1, 0, target(tmp_path), str(tmp_path))
    save_models(target(tmp_path), SkillVAE(4, 7, 3, 8), {})
    with pytest.raises(LfrError, match=r"'lift' by panda are hidden"):
        fit_any_task(job)


def test_the_prior_of_any_task_sees_the_targets_common_tasks(
    read: list[tuple[str, str, str]], tmp_path: Path
) -> None:
    skills = target(tmp_path / "skills")
    save_models(skills, SkillVAE(4, 7, 3, 8), {})
    fit_any_task(AnyTaskJob(SCENARIO, TRANSFER, PRIOR, 0.1, 0, skills, str(tmp_path)))
    assert read == [("target", "panda", "pick_place"), ("target", "panda", "nut_assembly")]
    prior = load_other_task(tmp_path / "prior")
    assert prior.layout_names == task_named("lift").observation.names
    assert all(column >= 0 for column in prior.columns)
    mu, _ = prior(torch.rand(5, len(prior.layout_names)))
    assert mu.shape == (5, 3)
    assert float(prior.inner.normalizer.mean.abs().sum()) > 0
