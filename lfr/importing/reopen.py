"""A dataset held against the file it was made of, through LeRobot's own reader."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lfr.data import tables
from lfr.errors import DataError
from lfr.importing.features import Layout, video_keys
from lfr.importing.robomimic import Demo


def compare_with_source(root: Path, repo_id: str, layout: Layout, demos: Sequence[Demo]) -> None:
    """Open a dataset with LeRobotDataset and compare it with its demonstrations.

    Raises:
        DataError: a count, a value or the number of a video's frames differs.
    """
    from lerobot.datasets import LeRobotDataset

    from lfr.data.video import count_frames

    dataset = LeRobotDataset(repo_id, root=root, video_backend="pyav")
    rows = dataset.hf_dataset.with_format("arrow")  # numpy would make float64 float32
    at = 0
    for demo in demos:
        part: Any = rows[at : at + len(demo)]
        for key, expected in layout.read(demo).items():
            found = tables.values(part, key)
            if found.dtype != expected.dtype or not np.array_equal(found, expected):
                raise DataError(
                    "the dataset differs from its file", file=demo.file,
                    column=f"{demo.name}: {key}", found=f"{found.dtype} {found.shape}",
                    expected=f"{expected.dtype} {expected.shape} and the same values",
                )  # fmt: skip
        at += len(demo)
    counts = {
        "frames": (dataset.num_frames, at),
        "episodes": (dataset.num_episodes, len(demos)),
        **{
            key: (sum(map(count_frames, root.glob(f"videos/{key}/*/*.mp4"))), at)
            for key in video_keys(layout.cameras).values()
        },
    }
    for column, (found, expected) in counts.items():
        if found != expected:
            raise DataError(
                "the dataset does not read back", file=root, column=column,
                found=found, expected=expected,
            )  # fmt: skip
    for index in (0, at - 1):
        dataset[index]  # decodes the first and the last frame
