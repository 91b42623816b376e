"""A made-up arm that reaches for something: its state, its targets, and a camera that sees it."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

FPS, SIZE = 20, 64
NAMES = ["shoulder.pos", "elbow.pos", "wrist.pos", "gripper.pos"]
STATE, ACTION, CAMERA = "observation.state", "action", "observation.images.top"


@dataclass
class Recording:
    """Episodes as arrays: states and actions (T, 4), pictures (T, SIZE, SIZE, 3) uint8."""

    states: list[np.ndarray]
    actions: list[np.ndarray]
    pictures: list[np.ndarray]


def recording(episodes: int = 16, seed: int = 0, *, drawn: bool = True) -> Recording:
    """Each reaches from where it happens to stand to where something happens to lie, and grasps."""
    random = np.random.default_rng(seed)
    states, actions, pictures = [], [], []
    for _ in range(episodes):
        length = int(random.integers(60, 90))
        t = np.linspace(0, 1, length)[:, None]
        start, end = random.uniform(-1.0, 1.0, (2, 3))
        smooth = 10 * t**3 - 15 * t**4 + 6 * t**5
        joints = start + (end - start) * smooth + 0.05 * np.sin(7 * t + random.uniform(0, 6, 3))
        gripper = (t > 0.8).astype(float) * 0.04
        target = np.concatenate([joints, gripper], axis=1)
        state = np.concatenate([target[:1], target[:1], target[:-2]])  # two frames behind
        noise = random.normal(0, 2e-4, (2, length, 4))
        states.append((state + noise[0]).astype(np.float32))
        actions.append((target + noise[1]).astype(np.float32))
        if drawn:
            pictures.append(np.stack([picture(one) for one in states[-1]]))
    return Recording(states, actions, pictures)


def picture(state: np.ndarray) -> np.ndarray:
    """A red hand over a textured table that is bluer to one side."""
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    table = 90 + 40 * np.sin(x / 2.0) * np.cos(y / 3.0)
    frame = np.stack([table, table + 20, table + 2 * x], axis=-1)
    at = (np.clip(state[:2] / 1.3, -1, 1) + 1) / 2 * (SIZE - 14) + 7
    hand = (np.abs(x - at[0]) < 6) & (np.abs(y - at[1]) < 6)
    frame[hand] = (220, 40, 30)
    return frame.clip(0, 255).astype(np.uint8)


def write(path: Path, of: Recording, *, pictures: bool = False) -> Path:
    """A LeRobot v3.0 dataset, without statistics, which are no matter here."""
    lengths = np.array([len(state) for state in of.states])
    ends, episode = np.cumsum(lengths), np.repeat(np.arange(len(lengths)), lengths)
    frame = np.concatenate([np.arange(length) for length in lengths])
    columns = {
        STATE: _vectors(of.states),
        ACTION: _vectors(of.actions),
        "timestamp": (frame / FPS).astype(np.float32),
        "frame_index": frame,
        "episode_index": episode,
        "index": np.arange(len(frame)),
        "task_index": np.zeros(len(frame), np.int64),
    }
    _table(path / "data/chunk-000/file-000.parquet", columns)
    rows = {
        "episode_index": np.arange(len(lengths)), "length": lengths,
        "tasks": [["Reach."]] * len(lengths), "dataset_from_index": ends - lengths,
        "dataset_to_index": ends,
    }  # fmt: skip
    for name in ("data", "meta/episodes", *([f"videos/{CAMERA}"] if pictures else [])):
        rows |= {f"{name}/{i}_index": np.zeros(len(lengths), np.int64) for i in ("chunk", "file")}
    number = {"dtype": "float32", "shape": [4], "names": NAMES}
    features: dict[str, dict] = {STATE: number, ACTION: number}
    for name in ("timestamp", "frame_index", "episode_index", "index", "task_index"):
        dtype = "float32" if name == "timestamp" else "int64"
        features[name] = {"dtype": dtype, "shape": [1], "names": None}
    if pictures:
        rows[f"videos/{CAMERA}/from_timestamp"] = (ends - lengths) / FPS
        rows[f"videos/{CAMERA}/to_timestamp"] = ends / FPS
        shape = {"shape": [SIZE, SIZE, 3], "names": ["height", "width", "channels"]}
        features[CAMERA] = {"dtype": "video", **shape, "info": {"video.codec": "h264"}}
        encode(path / f"videos/{CAMERA}/chunk-000/file-000.mp4", np.concatenate(of.pictures))
    _table(path / "meta/episodes/chunk-000/file-000.parquet", rows)
    _table(path / "meta/tasks.parquet", {"task_index": [0], "task": ["Reach."]})
    info = {
        "codebase_version": "v3.0", "robot_type": "arm", "fps": FPS, "features": features,
        "total_episodes": len(lengths), "total_frames": int(lengths.sum()), "total_tasks": 1,
        "chunks_size": 1000, "splits": {"train": f"0:{len(lengths)}"},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4",
    }  # fmt: skip
    (path / "meta/info.json").write_text(json.dumps(info))
    return path


def encode(file: Path, frames: np.ndarray, codec: str = "libx264", pixels: str = "yuv420p") -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(file), "w") as out:
        stream = out.add_stream(codec, rate=FPS, options={"g": "2", "crf": "20", "bf": "0"})
        stream.width, stream.height, stream.pix_fmt = SIZE, SIZE, pixels
        for frame in frames:
            out.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="rgb24")))
        out.mux(stream.encode())


Edit = Callable[[Recording], object]
K = 7
"""The episode in which a fault of one episode is."""


def of_state(edit: Callable[[np.ndarray], object]) -> Edit:
    """Change an episode's states in place."""
    return lambda of: edit(of.states[K])


def of_action(edit: Callable[[np.ndarray], object]) -> Edit:
    return lambda of: edit(of.actions[K])


def of_pictures(edit: Callable[[np.ndarray], np.ndarray]) -> Edit:
    """Put other pictures in the place of an episode's."""

    def change(of: Recording) -> None:
        of.pictures[K] = edit(of.pictures[K])

    return change


def _vectors(parts: Sequence[np.ndarray]) -> pa.Array:
    flat = np.concatenate(parts).astype(np.float32)
    return pa.FixedSizeListArray.from_arrays(pa.array(flat.ravel()), flat.shape[1])


def _table(file: Path, columns: dict) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(pa.table(columns), file)
