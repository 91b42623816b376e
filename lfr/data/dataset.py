"""Packing logs into a LeRobot v3.0 dataset.

The files are written directly, by LeRobot's own schemas and paths, and equal what its `add_frame`
and `save_episode` write (a test compares them), for three reasons: `save_episode` spends 290 ms on
a state-only episode, has no place for columns of an episode (lerobot issue 2999), and computes
wrong quantiles (issue 4156).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lfr.artifacts import file_hash, write_whole
from lfr.data.checks import check_dataset
from lfr.data.episode import FPS, IMAGES, Episode, Feature
from lfr.data.log_reader import read_log
from lfr.data.reopen import compare_with_logs
from lfr.data.stats import Stats, vector_stats
from lfr.errors import DataError

if TYPE_CHECKING:
    import pyarrow as pa
    import pyarrow.parquet as pq

MAX_BYTES = 100 * 2**20  # of one Parquet file, before compression; LeRobot's data_files_size_in_mb


def pack_dataset(
    logs: Sequence[Path], out: Path, *, video: bool = True, fps: int = FPS
) -> dict[str, Any]:
    """Pack logs, in this order, into the dataset `out`; what stood there is replaced at the end.

    It is built beside `out`, opened with LeRobotDataset and compared with the logs row by row, and
    only then given its name.

    Args:
        logs: MCAP logs of one robot and task.
        out: the dataset's folder; its repo_id is `lfr/<name of the folder>`.
        video: make `observation.images.<camera>` videos, where every log has images.
        fps: frames per second that the logs must have.

    Returns:
        Counts: episodes, frames, successes, cameras.

    Raises:
        DataError: a log is missing, cut off, or of another robot, task, layout or rate than the
            first; a value is not finite; or what was written does not read back as it should.
    """
    if not logs:
        raise DataError("no logs to pack; record episodes first", file=out)
    with write_whole(Path(out)) as partial:
        partial.mkdir()
        with closing(_DatasetWriter(partial, logs, video, fps)) as writer:
            for log in logs:
                writer.add(Path(log))
            writer.finish()
        check_dataset(partial, fps=fps)
        compare_with_logs(partial, f"lfr/{Path(out).name}", logs)
    return {
        "episodes": len(writer.rows),
        "frames": writer.frames,
        "successes": sum(row["success"] for row in writer.rows),
        "cameras": list(writer.cameras),
    }


class _DatasetWriter:
    """Writes data, videos and meta of one dataset, an episode at a time."""

    def __init__(self, root: Path, logs: Sequence[Path], video: bool, fps: int) -> None:
        from lerobot.datasets.feature_utils import get_hf_features_from_features
        from lerobot.datasets.utils import DEFAULT_DATA_PATH, DEFAULT_VIDEO_PATH
        from lerobot.utils.constants import DEFAULT_FEATURES

        from lfr.data.video import VideoWriter

        self.root, self.fps, self.first_log = root, fps, Path(logs[0])
        self.first = read_log(self.first_log)
        self.schema: Mapping[str, Feature] = self.first.schema
        self.features: dict[str, Any] = {
            key: {"dtype": f.dtype, "shape": f.shape, "names": list(f.names or ())}
            for key, f in self.schema.items()
        }
        self.default_features = DEFAULT_FEATURES
        arrow = get_hf_features_from_features({**self.features, **DEFAULT_FEATURES}).arrow_schema
        self.arrow: pa.Schema = arrow
        self.data_path = DEFAULT_DATA_PATH
        self.cameras = {
            camera: VideoWriter(
                root,
                IMAGES + camera,
                DEFAULT_VIDEO_PATH.replace("{video_key}", IMAGES + camera),
                fps,
            )
            for camera in (self.first.images if video else ())
        }
        self.rows: list[dict[str, Any]] = []  # of meta/episodes
        self.columns: dict[str, list[NDArray]] = {key: [] for key in self.arrow.names}
        self.tasks: list[str] = []
        self.frames = 0
        self._parquet: pq.ParquetWriter | None = None
        self._files, self._bytes = 0, 0

    def add(self, log: Path) -> None:
        episode = self.first if log == self.first_log else read_log(log)
        index = len(self.rows)
        self._check(episode, log, index)
        instruction = episode.metadata["instruction"]
        if instruction not in self.tasks:
            self.tasks.append(instruction)
        columns = self._columns(episode, index)
        stats = {key: vector_stats(values) for key, values in columns.items()}
        where: dict[str, Any] = self._write_rows(columns, len(episode))
        for camera, writer in self.cameras.items():
            try:
                place, stats[writer.key] = writer.write(episode.images[camera])
            except (OSError, ValueError) as error:
                raise DataError(
                    "an image that cannot be encoded",
                    file=log,
                    episode=index,
                    column=writer.key,
                    found=error,
                ) from error
            where |= place
        self.rows.append(
            {
                "episode_index": index,
                "tasks": [instruction],
                "length": len(episode),
                **where,
                "seed": episode.seed,
                "success": bool(episode.success),
                "robot": episode.robot,
                "task_name": episode.task,
                "log_file": log.name,
                "log_sha256": file_hash(log),
                **_flat(stats),
                "meta/episodes/chunk_index": 0,
                "meta/episodes/file_index": 0,
            }
        )
        self.frames += len(episode)

    def close(self) -> None:
        """Close the Parquet file and the videos, whole or not."""
        if self._parquet is not None:
            self._parquet.close()
        for camera in self.cameras.values():
            camera.close()

    def finish(self) -> None:
        """Close the files and write all of meta."""
        import pandas as pd
        import pyarrow as pa
        import pyarrow.parquet as pq
        from lerobot.datasets import CODEBASE_VERSION
        from lerobot.datasets.feature_utils import create_empty_dataset_info
        from lerobot.datasets.io_utils import write_info, write_stats, write_tasks
        from lerobot.datasets.utils import DEFAULT_EPISODES_PATH

        self.close()
        for camera in self.cameras.values():
            self.features[camera.key] = camera.feature()
        features = {**self.features, **self.default_features}
        info = create_empty_dataset_info(
            CODEBASE_VERSION, self.fps, features, bool(self.cameras), self.first.robot
        )
        info.total_episodes, info.total_frames = len(self.rows), self.frames
        info.total_tasks = len(self.tasks)
        info.splits = {"train": f"0:{len(self.rows)}"}
        write_info(info, self.root)

        stats = {key: vector_stats(np.concatenate(parts)) for key, parts in self.columns.items()}
        stats |= {camera.key: camera.stats for camera in self.cameras.values()}
        write_stats({key: stats[key] for key in features}, self.root)
        tasks = pd.Index(self.tasks, name="task")
        write_tasks(pd.DataFrame({"task_index": range(len(tasks))}, index=tasks), self.root)
        path = self.root / DEFAULT_EPISODES_PATH.format(chunk_index=0, file_index=0)
        path.parent.mkdir(parents=True)
        pq.write_table(pa.Table.from_pylist(self.rows), path, compression="snappy")

    def _columns(self, episode: Episode, index: int) -> dict[str, NDArray]:
        length = len(episode)
        columns = {key: episode.features[key] for key in self.schema}
        columns |= {
            "timestamp": (np.arange(length) / self.fps).astype(np.float32),
            "frame_index": np.arange(length),
            "episode_index": np.full(length, index),
            "index": np.arange(self.frames, self.frames + length),
            "task_index": np.full(length, self.tasks.index(episode.metadata["instruction"])),
        }
        for key, values in columns.items():
            self.columns[key].append(values)
        return columns

    def _write_rows(self, columns: Mapping[str, NDArray], length: int) -> dict[str, int]:
        """One row group for each episode, as LeRobot has it."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        size = sum(values.nbytes for values in columns.values())
        if self._parquet is not None and self._bytes + size > MAX_BYTES:
            self._parquet.close()
            self._parquet = None
        if self._parquet is None:
            path = self.root / self.data_path.format(
                chunk_index=self._files // 1000, file_index=self._files % 1000
            )
            path.parent.mkdir(parents=True, exist_ok=True)
            self._parquet = pq.ParquetWriter(
                path, schema=self.arrow, compression="snappy", use_dictionary=True
            )
            self._files, self._bytes = self._files + 1, 0
        arrays = [_arrow(columns[field.name], field.type) for field in self.arrow]
        self._parquet.write_table(pa.Table.from_arrays(arrays, schema=self.arrow))
        self._bytes += size
        return {
            "data/chunk_index": (self._files - 1) // 1000,
            "data/file_index": (self._files - 1) % 1000,
            "dataset_from_index": self.frames,
            "dataset_to_index": self.frames + length,
        }

    def _check(self, episode: Episode, log: Path, index: int) -> None:
        """An episode that does not belong to this dataset, or is not fit for one, is refused."""
        pairs = {
            "robot": (episode.robot, self.first.robot),
            "task": (episode.task, self.first.task),
            "fps": (episode.metadata["fps"], self.fps),
            "cameras": (sorted(set(self.cameras) & set(episode.images)), sorted(self.cameras)),
            **{
                key: (episode.schema[key].names, f.names)
                for key, f in self.schema.items()
                if key in episode.schema
            },
        }
        for column, (found, expected) in pairs.items():
            if found != expected:
                raise DataError(
                    f"a log of another kind than {self.first_log.name}",
                    file=log,
                    episode=index,
                    column=column,
                    found=found,
                    expected=expected,
                )
        for key, values in episode.features.items():
            if not np.isfinite(values).all():
                raise DataError(
                    "a value that is not finite",
                    file=log,
                    episode=index,
                    column=key,
                    found=f"{values[~np.isfinite(values)][0]}",
                    expected="finite numbers",
                )


def _arrow(values: NDArray, type: pa.DataType) -> pa.Array:
    import pyarrow as pa

    if pa.types.is_fixed_size_list(type):
        flat = pa.array(np.ascontiguousarray(values).reshape(-1), type.value_type)
        return pa.FixedSizeListArray.from_arrays(flat, type=type)
    return pa.array(values, type)


def _flat(stats: Mapping[str, Stats]) -> dict[str, Any]:
    return {
        f"stats/{key}/{name}": value.tolist()
        for key, values in stats.items()
        for name, value in values.items()
    }
