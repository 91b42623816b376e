"""Made-up state-only datasets of any size, in the layout that packing writes, within seconds."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from lfr.artifacts import read_json, write_json
from lfr.curation.exact_stats import dataset_stats, episode_stats
from lfr.data.episode import DONE, FEATURES, REWARD, SUCCESS, features_of
from lfr.data.layout import DATA_PATH, DEFAULT_FEATURES
from lfr.data.tables import VERSION
from lfr.embodiments import embodiment
from lfr.spaces import ROBOT_STATE
from lfr.tasks import task

EPISODES = "meta/episodes/chunk-000/file-000.parquet"
FILE_ROWS = 400_000  # of one Parquet file: about the 100 MB at which LeRobot begins another


@dataclass(frozen=True)
class Size:
    """How large it is to be; lengths are drawn uniformly."""

    episodes: int = 10_000
    shortest: int = 40  # frames
    longest: int = 110


def write_dataset(
    path: Path, size: Size, fps: int = 20, robot: str = "panda", task_name: str = "lift"
) -> int:
    """Write it and return the number of its rows. The same arguments give the same dataset."""
    rng = np.random.default_rng(0)
    lengths = rng.integers(size.shortest, size.longest + 1, size.episodes)
    rows, ends = int(lengths.sum()), np.cumsum(lengths)
    about = task(task_name)
    schema = features_of(embodiment(robot), about)
    columns: dict[str, np.ndarray] = {}
    for f in FEATURES:
        width = len(schema[f.key].names or ())
        columns[f.key] = np.tanh(rng.normal(0, 0.3, (rows, width)).astype(np.float32))
    columns["observation.state"][:, ROBOT_STATE.names.index("gripper_aperture")] *= 0.01
    last = np.zeros(rows, bool)
    last[ends - 1] = True
    columns |= {REWARD: columns[REWARD][:, 0], SUCCESS: last, DONE: last}
    frame = np.arange(rows) - np.repeat(ends - lengths, lengths)
    numbers = {
        "timestamp": (frame / fps).astype(np.float32),
        "frame_index": frame,
        "episode_index": np.repeat(np.arange(size.episodes), lengths),
        "index": np.arange(rows),
        "task_index": np.zeros(rows, np.int64),
    }
    columns |= {name: numbers[name] for name in DEFAULT_FEATURES}
    file = _write_rows(path, columns, ends, lengths)
    described = {
        key: {"dtype": f.dtype, "shape": [len(f.names or ())], "names": list(f.names or ())}
        for key, f in schema.items()
    }
    for key in DEFAULT_FEATURES:
        described[key] = {"dtype": str(columns[key].dtype), "shape": [1], "names": None}
    episodes = {
        "episode_index": np.arange(size.episodes),
        "tasks": pa.array([[about.instruction]] * size.episodes),
        "length": lengths,
        "data/chunk_index": np.zeros(size.episodes, np.int64),
        "data/file_index": file,
        "dataset_from_index": ends - lengths,
        "dataset_to_index": ends,
        "seed": np.arange(size.episodes),
        "success": np.ones(size.episodes, bool),
        "robot": [robot] * size.episodes,
        "task_name": [about.name] * size.episodes,
    }
    for key, values in columns.items():
        for name, value in episode_stats(values, lengths).items():
            episodes[f"stats/{key}/{name}"] = pa.array(list(value))
    (path / EPISODES).parent.mkdir(parents=True)
    pq.write_table(pa.table(episodes), path / EPISODES)
    write_json(path / "meta/stats.json", {k: dataset_stats(v) for k, v in columns.items()})
    index = pd.Index([about.instruction], name="task")
    pd.DataFrame({"task_index": [0]}, index=index).to_parquet(path / "meta/tasks.parquet")
    write_json(
        path / "meta/info.json",
        {
            "codebase_version": VERSION, "fps": fps, "features": described, "robot_type": robot,
            "total_episodes": size.episodes, "total_frames": rows, "total_tasks": 1,
            "chunks_size": 1000, "splits": {"train": f"0:{size.episodes}"},
            "data_path": DATA_PATH, "video_path": None,
        },
    )  # fmt: skip
    return rows


def as_of_robot(dataset: Path, out: Path, robot: str) -> None:
    """The same episodes as another arm's: links to the files, but for those that name the arm."""
    shutil.copytree(dataset, out, copy_function=os.link)
    info = out / "meta/info.json"
    write_json(info, read_json(info) | {"robot_type": robot})
    episodes = pq.read_table(out / EPISODES)
    place = episodes.column_names.index("robot")
    (out / EPISODES).unlink()
    renamed = episodes.set_column(place, "robot", pa.array([robot] * episodes.num_rows))
    pq.write_table(renamed, out / EPISODES)


@contextmanager
def scratch() -> Iterator[Path]:
    """A folder that is gone at the end, and with it what LeRobot keeps of each dataset it opens."""
    with tempfile.TemporaryDirectory(prefix="lfr-bench-") as name:
        os.environ["HF_DATASETS_CACHE"] = f"{name}/.cache"  # read when `datasets` is imported
        yield Path(name)


def _write_rows(
    path: Path, columns: dict[str, np.ndarray], ends: np.ndarray, lengths: np.ndarray
) -> np.ndarray:
    """One row group for each episode, as LeRobot has it; the file of each."""
    table = pa.table({key: _array(values) for key, values in columns.items()})
    files = (ends - lengths) // FILE_ROWS
    (path / "data/chunk-000").mkdir(parents=True)
    for number in np.unique(files):
        name = DATA_PATH.format(chunk_index=0, file_index=number)
        with pq.ParquetWriter(path / name, table.schema, compression="snappy") as writer:
            for episode in np.flatnonzero(files == number):
                start = int(ends[episode] - lengths[episode])
                writer.write_table(table.slice(start, int(lengths[episode])))
    return files


def _array(values: np.ndarray) -> pa.Array:
    if values.ndim == 1:
        return pa.array(values)
    flat = pa.array(np.ascontiguousarray(values).reshape(-1))
    return pa.FixedSizeListArray.from_arrays(flat, values.shape[1])
