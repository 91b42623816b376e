"""Who may read which demonstrations, and tasks that count alike."""

from pathlib import Path

import pytest
import torch

from lfr.errors import DataError, LfrError
from lfr.scenarios import Role, Scenario, transfers_of
from lfr.skills.demonstrations import balanced, read_visible
from lfr.skills.models import ModelJob, fit_prior, model_seed, prior_tasks, roles_of
from lfr.skills.params import SkillsParams

SCENARIO = Scenario("s1", ("pick_place", "nut_assembly"), {"panda": "lift", "sawyer": "stack"})


def job(robot: str, role: Role, task: str | None, folder: Path) -> ModelJob:
    folders = str(folder / "models"), str(folder / "nothing")
    return ModelJob(SCENARIO, robot, role, task, SkillsParams(), 0, *folders)


@pytest.mark.parametrize(
    ("robot", "role", "task"),
    [("panda", "target", "lift"), ("panda", "source", "lift"), ("sawyer", "oracle", "lift")],
)
def test_hidden_demonstrations_are_refused_before_anything_is_read(
    robot: str, role: Role, task: str, tmp_path: Path
) -> None:
    with pytest.raises(LfrError, match=f"{task}.*hidden from a model in role '{role}'"):
        read_visible(
            SCENARIO, robot, role, ("pick_place", task), horizon=10, held_out=0.1, seed=0,
            folder=tmp_path,
        )  # fmt: skip


def test_a_target_prior_of_the_new_task_cannot_be_trained(tmp_path: Path) -> None:
    with pytest.raises(LfrError, match="'lift' by panda are hidden"):
        fit_prior(job("panda", "target", "lift", tmp_path))
    assert not list(tmp_path.iterdir())


def test_a_dataset_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"no such dataset.*panda-pick_place"):
        read_visible(
            SCENARIO, "panda", "target", ("pick_place",), horizon=10, held_out=0.1, seed=0,
            folder=tmp_path,
        )  # fmt: skip


def test_priors_of_each_role() -> None:
    assert prior_tasks(SCENARIO, "sawyer", "source") == ("pick_place", "nut_assembly", "lift")
    assert prior_tasks(SCENARIO, "panda", "target") == ("pick_place", "nut_assembly")
    assert prior_tasks(SCENARIO, "panda", "oracle") == ("lift",)
    first = transfers_of(SCENARIO)[0]
    assert roles_of(first) == {"source": "sawyer", "target": "panda", "oracle": "panda"}


def test_no_two_models_start_from_the_same_weights(tmp_path: Path) -> None:
    jobs = [
        job("sawyer", "source", None, tmp_path),
        job("panda", "target", None, tmp_path),
        job("panda", "oracle", None, tmp_path),
        job("panda", "target", "pick_place", tmp_path),
        job("panda", "target", "nut_assembly", tmp_path),
    ]
    assert len({model_seed(one) for one in jobs}) == len(jobs)


def test_tasks_count_alike() -> None:
    windows = {"short": torch.zeros(3, 2, 7), "long": torch.ones(10, 2, 7)}
    together = balanced(windows, seed=0)
    assert together.shape == (20, 2, 7)
    assert float(together.mean()) == 0.5
    assert torch.equal(together, balanced(windows, seed=0))
