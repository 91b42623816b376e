"""What `lfr columns` prints is an entry that can be read, and trained from, as it stands."""

from pathlib import Path

import numpy as np
import pytest
from lerobot.datasets import LeRobotDataset

from lfr.cli import main
from lfr.data.external import read_external
from lfr.external import external

from . import made_up


@pytest.fixture(scope="module")
def datasets(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("columns")
    made_up.write_both(folder, episodes=1)
    return folder


def printed(path: Path, capsys: pytest.CaptureFixture[str], *more: str) -> str:
    assert main(["columns", str(path), *more]) == 0
    return capsys.readouterr().out


def test_an_entry_reads_the_dataset_as_it_stands(
    datasets: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    entry = printed(datasets / "crane", capsys)
    params = tmp_path / "params.yaml"
    indented = "".join(f"    {line}\n" for line in entry.splitlines())
    params.write_text(f"external:\n  arms:\n{indented}")
    arm = external(params).arms["crane"]
    assert set(arm.tasks) == {"push_it", "pull_it", "park_it"}
    found = read_external(arm, "park_it")
    oracle = LeRobotDataset("theirs/crane", root=datasets / "crane")
    rows = [oracle[i] for i in range(len(oracle)) if oracle[i]["task"] == "park it"]
    actions = np.array([row["action"].numpy() for row in rows])
    np.testing.assert_allclose(
        found.action_space.physical(found.actions.numpy()), actions, rtol=1e-5, atol=1e-3
    )
    numbers = [f"number.{name}" for name in ("y_mm", "x_mm", "gx", "gy")]
    assert found.observation_names == (*numbers[:2], "joint", *numbers[2:])
    # Every dimension comes near its bounds, so nothing of [-1, 1] is wasted.
    every = np.array([oracle[i]["action"].numpy() for i in range(len(oracle))])
    scaled = arm.action.low, arm.action.high
    np.testing.assert_allclose(scaled, (every.min(0), every.max(0)), rtol=2e-3, atol=1e-6)


def test_names_that_say_nothing_are_given_ones_that_say_so(
    datasets: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    numbers = ", ".join(f'"number.state.{place}"' for place in range(4))
    assert f"names: [{numbers}]" in printed(datasets / "puck-push", capsys)
    entry = printed(datasets / "crane", capsys)
    assert 'names: ["number.y_mm", "number.x_mm", "joint"]' in entry


def test_another_name_and_a_wrong_action(
    datasets: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert printed(datasets / "puck-push", capsys, "--arm", "mine").startswith("mine:\n")
    assert main(["columns", str(datasets / "puck-push"), "--action", "torque"]) == 2
    assert "column torque, found observation.state, action" in capsys.readouterr().err
