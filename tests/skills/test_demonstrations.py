"""Who may read which demonstrations, and tasks that count alike."""

from pathlib import Path

import pytest
import torch

from lfr.errors import DataError, LfrError
from lfr.scenarios import Role, Scenario
from lfr.skills.demonstrations import balanced, read_visible

SCENARIO = Scenario("s1", ("pick_place", "nut_assembly"), {"panda": "lift", "sawyer": "stack"})


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


def test_a_dataset_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"no such dataset.*panda-pick_place"):
        read_visible(
            SCENARIO, "panda", "target", ("pick_place",), horizon=10, held_out=0.1, seed=0,
            folder=tmp_path,
        )  # fmt: skip


def test_tasks_count_alike() -> None:
    windows = {"short": torch.zeros(3, 2, 7), "long": torch.ones(10, 2, 7)}
    together = balanced(windows, seed=0)
    assert together.shape == (20, 2, 7)
    assert float(together.mean()) == 0.5
    assert torch.equal(together, balanced(windows, seed=0))
