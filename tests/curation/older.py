"""A made-up arm's dataset as LeRobot v2.1, or v2.0, wrote it: a file for each episode."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from . import arm

TASKS = ("Reach.", "Return.")
DATA, VIDEO = (
    "data/chunk-{chunk:03d}/episode_{episode:06d}.parquet",
    "videos/chunk-{chunk:03d}/{key}/episode_{episode:06d}.mp4",
)


def data(episode: int, size: int = 1000) -> str:
    return DATA.format(chunk=episode // size, episode=episode)


def video(episode: int, size: int = 1000) -> str:
    return VIDEO.format(chunk=episode // size, episode=episode, key=arm.CAMERA)


def write(
    path: Path, of: arm.Recording, *, version: str = "v2.1", size: int = 1000, pictures: bool = True
) -> Path:
    """The dataset, `size` episodes to a folder; every second episode is of the other task."""
    features: dict[str, dict[str, Any]] = {
        key: {"dtype": "float32", "shape": [4], "names": arm.NAMES}
        for key in (arm.STATE, arm.ACTION)
    }
    if pictures:
        features[arm.CAMERA] = {
            "dtype": "video", "shape": [arm.SIZE, arm.SIZE, 3],
            "names": ["height", "width", "channel"],
            "info": {"video.fps": float(arm.FPS), "video.codec": "h264",
                     "video.pix_fmt": "yuv420p", "has_audio": False},
        }  # fmt: skip
    for name in ("timestamp", "frame_index", "episode_index", "index", "task_index"):
        dtype = "float32" if name == "timestamp" else "int64"
        features[name] = {"dtype": dtype, "shape": [1], "names": None}
    lengths = [len(state) for state in of.states]
    every: dict[str, list[np.ndarray]] = {}
    episodes, statistics = [], []
    for episode, length in enumerate(lengths):
        rows = {
            arm.STATE: of.states[episode],
            arm.ACTION: of.actions[episode],
            "timestamp": (np.arange(length) / arm.FPS).astype(np.float32),
            "frame_index": np.arange(length),
            "episode_index": np.full(length, episode),
            "index": sum(lengths[:episode]) + np.arange(length),
            "task_index": np.full(length, episode % len(TASKS)),
        }
        file = path / data(episode, size)
        file.parent.mkdir(parents=True, exist_ok=True)
        columns = {
            key: pa.FixedSizeListArray.from_arrays(pa.array(v.ravel()), v.shape[1])
            if v.ndim > 1 else pa.array(v)
            for key, v in rows.items()
        }  # fmt: skip
        pq.write_table(pa.table(columns), file)
        stats = {key: _stats(values) for key, values in rows.items()}
        if pictures:
            arm.encode(path / video(episode, size), of.pictures[episode])
            stats[arm.CAMERA] = _pixels(of.pictures[episode])
        words = TASKS[episode % len(TASKS)]
        episodes.append({"episode_index": episode, "tasks": [words], "length": length})
        statistics.append({"episode_index": episode, "stats": stats})
        for key, values in rows.items():
            every.setdefault(key, []).append(values)
    (path / "meta").mkdir()
    tasks = [{"task_index": i, "task": words} for i, words in enumerate(TASKS)]
    lines(path / "meta/tasks.jsonl", tasks)
    lines(path / "meta/episodes.jsonl", episodes)
    if version == "v2.1":
        lines(path / "meta/episodes_stats.jsonl", statistics)
    else:
        whole = {key: _stats(np.concatenate(values)) for key, values in every.items()}
        if pictures:
            whole[arm.CAMERA] = _pixels(np.concatenate(of.pictures))
        for stats in whole.values():
            del stats["count"]
        (path / "meta/stats.json").write_text(json.dumps(whole))
    info = {
        "codebase_version": version, "robot_type": "arm", "fps": arm.FPS, "features": features,
        "total_episodes": len(lengths), "total_frames": sum(lengths), "total_tasks": len(TASKS),
        "total_videos": len(lengths) * pictures, "total_chunks": -(-len(lengths) // size),
        "chunks_size": size, "splits": {"train": f"0:{len(lengths)}"},
        "data_path": "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
        "video_path": "videos/chunk-{episode_chunk:03d}/{video_key}/"
        "episode_{episode_index:06d}.mp4",
    }  # fmt: skip
    (path / "meta/info.json").write_text(json.dumps(info))
    return path


def lines(file: Path, rows: list[dict[str, Any]]) -> None:
    file.write_text("".join(json.dumps(row) + "\n" for row in rows))


def change(file: Path, edit: Any) -> None:
    """Have the rows of a file of JSON lines changed in place."""
    rows = [json.loads(line) for line in file.read_text().splitlines()]
    edit(rows)
    lines(file, rows)


def _stats(values: np.ndarray) -> dict[str, Any]:
    """As LeRobot 0.3 has it: numpy's, in the precision of the values."""
    rows = values.reshape(len(values), -1)
    named = {
        name: getattr(np, name)(rows, axis=0).tolist() for name in ("min", "max", "mean", "std")
    }
    return {**named, "count": [len(rows)]}


def _pixels(pictures: np.ndarray) -> dict[str, Any]:
    some = (pictures[::10] / 255).astype(np.float32).transpose(0, 3, 1, 2)
    return {
        name: getattr(np, name)(some, axis=(0, 2, 3)).reshape(3, 1, 1).tolist()
        for name in ("min", "max", "mean", "std")
    } | {"count": [len(some)]}
