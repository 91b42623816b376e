"""The clean datasets that faults are planted into, and others in which there is none.

`own`: demonstrations of this project's, as its pipeline records and packs them, beside their logs.
`arm`: the same as most LeRobot datasets are: the state is joint positions and the gripper, the
action where they are to be two frames later, one camera, nothing of this project's besides.
`arm2d`: `arm` with a feature of two dimensions. `lerobot`: `arm`'s episodes, recorded by LeRobot.
"""

from __future__ import annotations

import dataclasses
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from benchmarks.checkers.dataset_copy import DatasetCopy
from lfr.curation.contents import DEFAULT_FEATURES
from lfr.params import read_section

ROBOT, TASK = "panda-joint_position", "lift"
EPISODES = 20
NAMES = ("own", "arm", "arm2d", "lerobot")
JOINTS = [*(f"joint_{i}.pos" for i in range(1, 8)), "gripper.pos"]
CAMERA = "observation.images.top"
AHEAD = 2  # frames, from an action to the state that it asks for
SENSOR = 2e-4  # rad and m, of noise in what is measured and in what is commanded
TOUCH = "observation.tactile"


def make_bases(
    work: Path, dataset: Path | None = None, logs: Path | None = None, names: Sequence[str] = NAMES
) -> None:
    """The datasets of these names as ``work/<name>``, and the logs of `own` as ``work/own-logs``.

    Args:
        dataset: what to take as `own` in place of recording it: one of this project's, of one file
            of rows, one of episodes and one video.
        logs: those that it was packed from.
    """
    own = work / "own"
    if not own.is_dir():
        if dataset is None:
            _record(work, own)
        else:
            shutil.copytree(dataset, own)
            if logs is not None:
                shutil.copytree(logs, work / "own-logs")
    for name, make in (("arm", _arm), ("arm2d", _touched), ("lerobot", _by_lerobot)):
        if name in names and not (work / name).is_dir():
            partial = work / f".partial-{name}"
            shutil.rmtree(partial, ignore_errors=True)
            make(work, partial)
            partial.rename(work / name)


def _record(work: Path, own: Path) -> None:
    from lfr.data.dataset import pack_dataset
    from lfr.data.log_reader import list_logs
    from lfr.demos.recorder import RecordParams, record_demonstrations

    params = dataclasses.replace(read_section(RecordParams, "record"), episodes=EPISODES)
    logs = work / "own-logs"
    record_demonstrations(ROBOT, TASK, params, logs, work / "attempts")
    pack_dataset(list_logs(logs), own)
    shutil.rmtree(work / "attempts")


def _arm(work: Path, root: Path) -> None:
    copy = DatasetCopy.of(work / "own", root)
    rng = np.random.default_rng(0)
    features, old = copy.info["features"], copy.camera
    aperture = features["observation.state"]["names"].index("gripper_aperture")
    gripper = copy.values("observation.state")[:, aperture]
    measured = np.column_stack([copy.values("observation.joint_position"), gripper])
    ends = np.repeat(copy.of_episodes("dataset_to_index"), copy.of_episodes("length"))
    ahead = np.minimum(np.arange(len(measured)) + AHEAD, ends - 1)
    vectors = {"observation.state": measured, "action": measured[ahead]}
    vectors = {key: _noisy(rng, values, SENSOR) for key, values in vectors.items()}
    video = copy.root / "videos"
    (video / old).rename(video / CAMERA)
    copy.rows = pa.table(
        {key: _fixed(values) for key, values in vectors.items()}
        | {key: copy.rows[key] for key in DEFAULT_FEATURES}
    )
    columns = {}
    for name in copy.episodes.column_names:
        feature = name.split("/")[1] if name.startswith("stats/") else ""
        if "/" not in name and name not in LEROBOTS:
            continue
        if feature in ("", old, *DEFAULT_FEATURES):
            columns[name.replace(old, CAMERA)] = copy.episodes[name]
    copy.episodes = pa.table(columns)
    vector = {"dtype": "float32", "shape": [len(JOINTS)], "names": JOINTS}
    copy.info |= {
        "robot_type": "franka_follower",
        "features": {"action": vector, "observation.state": vector, CAMERA: features[old]}
        | {key: features[key] for key in DEFAULT_FEATURES},
    }
    copy.stats = {CAMERA: copy.stats[old]}
    copy.restat()
    copy.save()
    for extra in [path for path in root.iterdir() if path.name not in ("data", "meta", "videos")]:
        shutil.rmtree(extra) if extra.is_dir() else extra.unlink()


LEROBOTS = ("episode_index", "tasks", "length", "dataset_from_index", "dataset_to_index")


def _touched(work: Path, root: Path) -> None:
    copy = DatasetCopy.of(work / "arm", root)
    pressure = np.random.default_rng(1).normal(0.5, 0.1, (copy.rows.num_rows, 4, 4))
    type = pa.list_(pa.list_(pa.float32()))
    copy.rows = copy.rows.append_column(TOUCH, pa.array(pressure.tolist(), type))
    copy.info["features"][TOUCH] = {
        "dtype": "float32", "shape": [4, 4], "names": ["row", "column"]
    }  # fmt: skip
    copy.restat(TOUCH)
    copy.save()


def _by_lerobot(work: Path, root: Path) -> None:
    from lerobot.datasets import LeRobotDataset

    arm = DatasetCopy(work / "arm")
    features: dict[str, Any] = {
        key: {name: f[name] for name in ("dtype", "shape", "names")}
        for key, f in arm.info["features"].items()
        if key not in DEFAULT_FEATURES
    }
    recorded = LeRobotDataset.create(
        "benchmarks/lerobot", arm.info["fps"], features, root=root, robot_type="franka_follower"
    )
    states, actions, frames = (
        arm.values("observation.state"), arm.values("action"), arm.frames()
    )  # fmt: skip
    for episode, (task,) in enumerate(arm.of_episodes("tasks")):
        span = arm.span(episode)
        for row in range(span.start, span.stop):
            recorded.add_frame({"observation.state": states[row], "action": actions[row],
                                CAMERA: frames[row], "task": task})  # fmt: skip
        recorded.save_episode()
    recorded.finalize()


def _noisy(rng: np.random.Generator, values: Any, by: float) -> np.ndarray:
    return (values + rng.normal(0, by, values.shape)).astype(np.float32)


def _fixed(values: np.ndarray) -> pa.Array:
    return pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), values.shape[1])
