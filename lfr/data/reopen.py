"""A dataset held against what it was made of, through LeRobot's own reader."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.data import tables
from lfr.data.episode import ACTION
from lfr.errors import DataError


def compare_with_sources(
    root: Path, repo_id: str, episodes: Iterable[tuple[Path, Mapping[str, NDArray]]]
) -> None:
    """Open a dataset with LeRobotDataset and compare it with its episodes.

    Args:
        episodes: for each, the file it was read from and its features.

    Raises:
        DataError: a count, a value or the number of a video's frames differs.
    """
    from lerobot.datasets import LeRobotDataset

    from lfr.data.video import count_frames

    dataset = LeRobotDataset(repo_id, root=root, video_backend="pyav")
    rows = dataset.hf_dataset.with_format("arrow")  # numpy would make float64 float32
    at = index = 0
    for index, (file, features) in enumerate(episodes, start=1):
        part: Any = rows[at : at + len(features[ACTION])]
        for key, expected in features.items():
            found = tables.values(part, key)
            if found.dtype != expected.dtype or not np.array_equal(found, expected):
                raise DataError(
                    "the dataset differs from its source",
                    file=file,
                    episode=index - 1,
                    column=key,
                    found=f"{found.dtype} {found.shape}",
                    expected=f"{expected.dtype} {expected.shape} and the same values",
                )
        at += len(features[ACTION])
    counts = {
        "frames": (dataset.num_frames, at),
        "episodes": (dataset.num_episodes, index),
        **{
            camera: (sum(map(count_frames, root.glob(f"videos/{camera}/*/*.mp4"))), at)
            for camera in dataset.meta.video_keys
        },
    }
    for column, (found, expected) in counts.items():
        if found != expected:
            raise DataError(
                "the dataset does not read back", file=root, column=column,
                found=found, expected=expected,
            )  # fmt: skip
    for row in (0, at - 1):
        dataset[row]  # decodes the first and the last frame
