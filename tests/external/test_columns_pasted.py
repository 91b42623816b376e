"""What ``lfr columns`` prints is pasted into params.yaml and read again, whatever the dataset."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from lfr.data.external import read_external
from lfr.errors import DataError
from lfr.external import external
from lfr.importing.columns_command import LONGEST_KEY, MOST_TASKS, arm_entry
from tests.curation import arm

DATA = "data/chunk-000/file-000.parquet"


def pasted(path: Path, folder: Path):
    """The arm that a params.yaml with the printed entry has."""
    entry = arm_entry(path, "mine").replace("\n", "\n    ")
    file = folder / "params.yaml"
    file.write_text(f"external:\n  arms:\n    {entry}\n  scenarios: {{}}\n  transfers: []\n")
    return external(file).arms["mine"]


@pytest.mark.parametrize("fps", [20, 20.0, 19.98])
def test_any_rate(fps: float, tmp_path: Path) -> None:
    path = arm.write(tmp_path / "arm", arm.recording(4))
    info = json.loads((path / "meta/info.json").read_text())
    (path / "meta/info.json").write_text(json.dumps(info | {"fps": fps}))
    if fps != 20:  # rows at that rate
        table = pq.read_table(path / DATA)
        frames = table["frame_index"].to_numpy()
        at = table.column_names.index("timestamp")
        seconds = (frames / fps).astype(np.float32)
        pq.write_table(table.set_column(at, "timestamp", [seconds]), path / DATA)
    found = pasted(path, tmp_path)
    assert found.fps == fps
    assert len(read_external(found, "reach")) == len(np.concatenate(arm.recording(4).states))


@pytest.mark.parametrize("name", ["set #1: a", "ünï", "-arm", "a b"])
def test_any_folder(name: str, tmp_path: Path) -> None:
    found = pasted(arm.write(tmp_path / name, arm.recording(2)), tmp_path)
    assert found.dataset("reach") == tmp_path / name


def with_tasks(path: Path, words: list[str]) -> Path:
    """Each episode has a task of its own."""
    arm.write(path, arm.recording(len(words)))
    file = path / "meta/episodes/chunk-000/file-000.parquet"
    table = pq.read_table(file)
    at = table.column_names.index("tasks")
    pq.write_table(table.set_column(at, "tasks", [[[one] for one in words]]), file)
    return path


def test_any_words(tmp_path: Path) -> None:
    words = ["拿起杯子", "放下杯子", "Reach it!", "reach it?", "2 cups", "a" * 90, 'say "no": #1']
    tasks = pasted(with_tasks(tmp_path / "arm", words), tmp_path).tasks
    assert [task.instruction for task in tasks.values()] == words
    assert all(len(name) <= LONGEST_KEY + 3 for name in tasks)
    assert list(tasks)[:4] == ["task", "task_2", "reach_it", "reach_it_2"]


def test_more_tasks_than_anybody_reads(tmp_path: Path) -> None:
    path = with_tasks(tmp_path / "arm", [f"do {i}" for i in range(MOST_TASKS + 3)])
    assert arm_entry(path).splitlines()[-1].endswith("and 3 more, as meta/tasks.parquet says")
    assert len(pasted(path, tmp_path).tasks) == MOST_TASKS


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_an_action_without_bounds(value: float, tmp_path: Path) -> None:
    of = arm.recording(3)
    of.actions[1][5, 2] = value
    path = arm.write(tmp_path / "arm", of)
    with pytest.raises(DataError, match=r"episode 1, column action, dimension wrist\.pos, found"):
        arm_entry(path)
