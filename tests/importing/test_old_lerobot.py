"""What writes refuses a LeRobot v2.1 dataset with a command, and that command converts it."""

import json
import runpy
import shlex
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from lfr.cli import main
from lfr.data.tables import DatasetFiles
from lfr.data.windows import read_dataset

LENGTHS = (4, 3)
FEATURES = {
    "observation.state": 2,
    "observation.environment_state": 3,
    "action": 2,
    "next.reward": 1,
    "next.success": 1,
}


def write_v21(root: Path) -> pd.DataFrame:
    """A dataset in LeRobot v2.1's layout: a Parquet file an episode, JSON lines beside."""
    rng = np.random.default_rng(0)
    (root / "meta").mkdir(parents=True)
    (root / "data/chunk-000").mkdir(parents=True)
    tables, stats = [], []
    for episode, length in enumerate(LENGTHS):
        columns: dict[str, object] = {}
        for key, size in FEATURES.items():
            values = rng.normal(size=(length, size)).astype(np.float32)
            values = values > 0 if key == "next.success" else values
            columns[key] = list(values) if size > 1 else values[:, 0]
        columns["timestamp"] = (np.arange(length) / 10).astype(np.float32)
        columns["frame_index"] = np.arange(length)
        columns["episode_index"] = np.full(length, episode)
        columns["index"] = sum(LENGTHS[:episode]) + np.arange(length)
        columns["task_index"] = np.zeros(length, np.int64)
        table = pd.DataFrame(columns)
        table.to_parquet(root / f"data/chunk-000/episode_{episode:06d}.parquet")
        tables.append(table)
        flat = {key: np.stack([np.atleast_1d(v) for v in table[key]]) * 1.0 for key in table}
        of = {
            key: {
                **{
                    name: getattr(v, name)(axis=0).tolist()
                    for name in ("min", "max", "mean", "std")
                },
                "count": [length],
            }
            for key, v in flat.items()
        }
        stats.append({"episode_index": episode, "stats": of})
    kinds = {"next.success": "bool", **dict.fromkeys(("timestamp",), "float32")}
    features = {
        key: {
            "dtype": kinds.get(key, "float32" if key in FEATURES else "int64"),
            "shape": [FEATURES.get(key, 1)],
            "names": [f"{key}.{i}" for i in range(FEATURES[key])] if key in FEATURES else None,
        }
        for key in tables[0]
    }
    info = {
        "codebase_version": "v2.1", "robot_type": "arm", "fps": 10, "features": features,
        "total_episodes": len(LENGTHS), "total_frames": sum(LENGTHS), "total_tasks": 1,
        "total_videos": 0, "total_chunks": 1, "chunks_size": 1000, "splits": {"train": "0:2"},
        "data_path": "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
        "video_path": None,
    }  # fmt: skip
    (root / "meta/info.json").write_text(json.dumps(info))
    lines = {
        "tasks": [{"task_index": 0, "task": "push"}],
        "episodes": [
            {"episode_index": i, "tasks": ["push"], "length": n} for i, n in enumerate(LENGTHS)
        ],
        "episodes_stats": stats,
    }
    for name, rows in lines.items():
        text = "".join(json.dumps(row) + "\n" for row in rows)
        (root / f"meta/{name}.jsonl").write_text(text)
    return pd.concat(tables, ignore_index=True)


def test_the_command_of_the_error_converts_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    root = tmp_path / "mine" / "old pushes"
    rows = write_v21(root)
    assert main(["import", str(root), "--to", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert "found v2.1, expected v3.0" in error
    command = error.split("with: ")[1].split(": /")[0]
    program, dash_m, module, *arguments = shlex.split(command)
    assert (program, dash_m) == ("python", "-m")
    assert "--push-to-hub=false" in arguments  # LeRobot's default is to upload

    monkeypatch.setattr(sys, "argv", [module, *arguments])
    runpy.run_module(module, run_name="__main__")
    assert DatasetFiles.open(root).info["codebase_version"] == "v3.0"
    found = read_dataset(root)
    np.testing.assert_array_equal(found.actions.numpy(), np.stack(rows["action"].tolist()))
    assert found.lengths.tolist() == list(LENGTHS)
    assert main(["import", str(root), "--to", str(tmp_path / "out")]) == 2
    assert "nothing to import" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        ["card", "OLD"],
        ["edit", "delete", "OLD", "--episodes", "0", "--out", "new"],
        ["edit", "split", "OLD", "all=0-1", "--out", "new"],
        ["publish", "OLD", "--to", "new"],
    ],
)
def test_everything_that_writes_says_that_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str]
) -> None:
    write_v21(tmp_path / "old")
    paths = {"OLD": str(tmp_path / "old"), "new": str(tmp_path / "new")}
    assert main([paths.get(argument, argument) for argument in arguments]) == 2
    assert not (tmp_path / "new").exists()
    error = capsys.readouterr().err
    assert f"--root={tmp_path / 'old'}" in error
    assert "found v2.1, expected v3.0" in error


def test_a_folder_that_is_no_dataset(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(tmp_path), "--to", str(tmp_path / "out")]) == 2
    assert "a folder: " in capsys.readouterr().err
