"""Packing state-only episodes: from logs to a checked dataset, against LeRobot's `save_episode`.

    python -m benchmarks.packing [--episodes 50] [--repeats 5] [--out results/benchmarks]

Ours is all that the pack stage does: every log is read and hashed, the dataset written, checked,
opened with LeRobotDataset and compared with its logs, which are read once more. LeRobot's side is
`add_frame`, `save_episode` and `finalize` of the same frames, which lie in memory already; it
checks and hashes nothing. The second figure gives LeRobot's side the logs to start from as well,
read once, by our reader. Both sides' rows must be equal. The logs are the recorder's own, without
pictures. Times are the wall clock, syncing to disk included, so it needs a quiet machine.
"""

from __future__ import annotations

import argparse
import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq

from benchmarks._datasets import scratch
from benchmarks._figures import FOLDER, Figure, against, show, write
from lfr.data.dataset import pack_dataset
from lfr.data.episode import Episode
from lfr.data.log_reader import list_logs, read_log
from lfr.demos.recorder import RecordParams, record_demonstrations
from lfr.params import read_section

ROBOT, TASK = "panda", "lift"
RATIO_GOAL = 3.0

Frames = list[dict[str, Any]]


@dataclass(frozen=True)
class Seconds:
    """What one round took: packing logs, reading logs to frames, saving frames with LeRobot."""

    pack: float
    read: float
    save: float


def frames_of(episode: Episode) -> Frames:
    """An episode as LeRobot's `add_frame` wants it."""
    instruction = episode.metadata["instruction"]
    return [
        {key: np.atleast_1d(values[t]) for key, values in episode.features.items()}
        | {"task": instruction}
        for t in range(len(episode))
    ]


def features_of(episode: Episode) -> dict[str, Any]:
    """An episode's features as LeRobot wants them."""
    return {
        key: {"dtype": f.dtype, "shape": f.shape, "names": list(f.names or ())}
        for key, f in episode.schema.items()
    }


def save_with_lerobot(
    episodes: Sequence[Frames], features: dict[str, Any], root: Path, about: Episode
) -> None:
    """Record the frames of all episodes with LeRobot's own writer."""
    from datasets import disable_progress_bars
    from lerobot.datasets import LeRobotDataset

    disable_progress_bars()  # one for each episode; opening a dataset brings them back
    recorded = LeRobotDataset.create(
        f"lfr/{root.name}", about.metadata["fps"], features,
        root=root, robot_type=about.robot, use_videos=False, video_backend="pyav",
    )  # fmt: skip
    for frames in episodes:
        for frame in frames:
            recorded.add_frame(frame)
        recorded.save_episode()
    recorded.finalize()


def one_round(logs: Sequence[Path], folder: Path, *, theirs_first: bool) -> Seconds:
    """Both sides once, into datasets that are compared and removed."""
    about = read_log(logs[0])
    features = features_of(about)
    ours, theirs = folder / "ours", folder / "theirs"
    episodes: list[Frames] = []
    acts: dict[str, Callable[[], object]] = {
        "pack": lambda: pack_dataset(logs, ours),
        "read": lambda: episodes.extend(frames_of(read_log(log)) for log in logs),
        "save": lambda: save_with_lerobot(episodes, features, theirs, about),
    }
    order = ("read", "save", "pack") if theirs_first else ("pack", "read", "save")
    seconds = {name: _seconds(acts[name]) for name in order}
    assert pq.read_table(ours / "data").equals(pq.read_table(theirs / "data")), "other rows"
    shutil.rmtree(ours)
    shutil.rmtree(theirs)
    return Seconds(**seconds)


def measure(logs: Sequence[Path], folder: Path, repeats: int) -> list[Figure]:
    """Both figures, from the same rounds after one to warm up; each printed."""
    rounds = [one_round(logs, folder, theirs_first=bool(n % 2)) for n in range(repeats + 1)][1:]
    sides = {
        "pack_from_logs/save_episode_from_memory": lambda each: each.save,
        "pack_from_logs/read_logs_and_save_episode": lambda each: each.read + each.save,
    }
    figures = []
    for name, theirs in sides.items():
        pairs = [(len(logs) / each.pack, len(logs) / theirs(each)) for each in rounds]
        figures.append(against(name, "episodes/s", RATIO_GOAL, pairs))
        show(figures[-1])
    return figures


def _seconds(act: Callable[[], object]) -> float:
    began = time.perf_counter()
    act()
    return time.perf_counter() - began


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--episodes", type=int, default=50)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--out", type=Path, default=FOLDER)
    arguments = parser.parse_args()
    params = read_section(RecordParams, "record")
    params = replace(params, episodes=arguments.episodes, cameras=())
    with scratch() as folder:
        counts = record_demonstrations(ROBOT, TASK, params, folder / "logs", folder / "work")
        print(f"{counts['episodes']} episodes, {counts['frames']} frames", flush=True)
        figures = measure(list_logs(folder / "logs"), folder, arguments.repeats)
    print(write("packing", figures, arguments.out))


if __name__ == "__main__":
    main()
