"""What a dataset says of itself: its folder `meta`, with a row for each episode."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lfr.data.layout import DEFAULT_FEATURES, EPISODES_PATH
from lfr.data.stats import Stats


class MetaWriter:
    """Collects what is known of each episode, and writes it at the end.

    Attributes:
        rows: of meta/episodes, one for each episode.
        tasks: the instructions, in the order in which they came.
    """

    def __init__(self, root: Path, robot: str, fps: int) -> None:
        self.rows: list[dict[str, Any]] = []
        self.tasks: list[str] = []
        self._root, self._robot, self._fps = root, robot, fps

    def task_index(self, instruction: str) -> int:
        """The index of a task, which is a new one where it was not met before."""
        if instruction not in self.tasks:
            self.tasks.append(instruction)
        return self.tasks.index(instruction)

    def add(
        self,
        length: int,
        instruction: str,
        where: Mapping[str, Any],
        columns: Mapping[str, Any],
        stats: Mapping[str, Stats],
    ) -> None:
        """Add the row of the next episode.

        Args:
            length: number of its frames.
            where: which files hold its frames and images, by column of meta/episodes.
            columns: what else is kept of an episode, of the same names and types for all.
            stats: its statistics, by feature.
        """
        self.rows.append(
            {
                "episode_index": len(self.rows),
                "tasks": [instruction],
                "length": length,
                **where,
                **columns,
                **_flat(stats),
                "meta/episodes/chunk_index": 0,
                "meta/episodes/file_index": 0,
            }
        )

    def write(self, features: Mapping[str, Mapping[str, Any]], stats: Mapping[str, Stats]) -> None:
        """Write all of meta.

        Args:
            features: their entries in info.json, LeRobot's own aside.
            stats: of each feature over all episodes, LeRobot's own included.
        """
        import pandas as pd
        import pyarrow as pa
        import pyarrow.parquet as pq
        from lerobot.datasets import CODEBASE_VERSION
        from lerobot.datasets.feature_utils import create_empty_dataset_info
        from lerobot.datasets.io_utils import write_info, write_stats, write_tasks

        every: dict[str, Any] = {**features, **DEFAULT_FEATURES}
        video = any(feature["dtype"] == "video" for feature in every.values())
        info = create_empty_dataset_info(CODEBASE_VERSION, self._fps, every, video, self._robot)
        info.total_episodes = len(self.rows)
        info.total_frames = sum(row["length"] for row in self.rows)
        info.total_tasks = len(self.tasks)
        info.splits = {"train": f"0:{len(self.rows)}"}
        write_info(info, self._root)
        write_stats({key: stats[key] for key in every}, self._root)
        tasks = pd.Index(self.tasks, name="task")
        write_tasks(pd.DataFrame({"task_index": range(len(tasks))}, index=tasks), self._root)
        path = self._root / EPISODES_PATH.format(chunk_index=0, file_index=0)
        path.parent.mkdir(parents=True)
        pq.write_table(pa.Table.from_pylist(self.rows), path, compression="snappy")


def _flat(stats: Mapping[str, Stats]) -> dict[str, Any]:
    return {
        f"stats/{key}/{name}": value.tolist()
        for key, values in stats.items()
        for name, value in values.items()
    }
