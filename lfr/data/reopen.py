"""A dataset held against the logs it was packed from, through LeRobot's own reader."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lfr.data.log_reader import read_log
from lfr.errors import DataError


def compare_with_logs(root: Path, repo_id: str, logs: Sequence[Path]) -> None:
    """Open a dataset with LeRobotDataset and compare it with its logs.

    Raises:
        DataError: a count, a value or the number of a video's frames differs.
    """
    from lerobot.datasets import LeRobotDataset

    from lfr.data.video import count_frames

    dataset = LeRobotDataset(repo_id, root=root, video_backend="pyav")
    rows = dataset.hf_dataset.with_format("numpy")
    at = 0
    for index, log in enumerate(logs):
        episode = read_log(Path(log))
        part = rows[at : at + len(episode)]
        for key, expected in episode.features.items():
            found = np.asarray(part[key])
            if found.dtype != expected.dtype or not np.array_equal(found, expected):
                raise DataError(
                    "the packed dataset differs from its log",
                    file=log,
                    episode=index,
                    column=key,
                    found=f"{found.dtype} {found.shape}",
                    expected=f"{expected.dtype} {expected.shape} and the same values",
                )
        at += len(episode)
    counts = {
        "frames": (dataset.num_frames, at),
        "episodes": (dataset.num_episodes, len(logs)),
        **{
            camera: (sum(map(count_frames, root.glob(f"videos/{camera}/*/*.mp4"))), at)
            for camera in dataset.meta.video_keys
        },
    }
    for column, (found, expected) in counts.items():
        if found != expected:
            raise DataError(
                "the packed dataset does not read back", file=root, column=column,
                found=found, expected=expected,
            )  # fmt: skip
    for index in (0, at - 1):
        dataset[index]  # decodes the first and the last frame
