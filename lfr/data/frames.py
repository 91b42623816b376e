"""The frames of a dataset: its folder `data`, one row for each control step."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lfr.data.episode import ACTION
from lfr.data.layout import CHUNK_SIZE, DATA_MEGABYTES, DATA_PATH, DEFAULT_FEATURES, row_schema
from lfr.data.stats import Stats, vector_stats

if TYPE_CHECKING:
    import pyarrow as pa
    import pyarrow.parquet as pq

MAX_BYTES = DATA_MEGABYTES * 2**20  # of one Parquet file, before compression


class FrameWriter:
    """Writes the frames of episodes one after the other into as few Parquet files as fit.

    Attributes:
        episodes, frames: how many were written.
    """

    def __init__(self, root: Path, features: Mapping[str, Mapping[str, Any]], fps: int) -> None:
        """For the dataset at `root`, with these entries of its info.json, LeRobot's own aside."""
        self.episodes, self.frames = 0, 0
        self._root, self._fps = root, fps
        self._keys = tuple(features)
        self._schema: pa.Schema = row_schema({**features, **DEFAULT_FEATURES})
        self._columns: dict[str, list[NDArray]] = {key: [] for key in self._schema.names}
        self._parquet: pq.ParquetWriter | None = None
        self._files, self._bytes = 0, 0

    def write(
        self, features: Mapping[str, NDArray], task_index: int
    ) -> tuple[dict[str, int], dict[str, Stats]]:
        """Write one episode's frames.

        Args:
            features: by key, (T, D), a scalar feature (T,), each in its dtype.

        Returns:
            Where they are, as the columns of meta/episodes, and the statistics of each column.
        """
        length = len(features[ACTION])
        columns = self._columns_of(features, length, task_index)
        for key, values in columns.items():
            self._columns[key].append(values)
        stats = _stats(columns.items())
        self._write_row_group(columns)
        where = {
            "data/chunk_index": (self._files - 1) // CHUNK_SIZE,
            "data/file_index": (self._files - 1) % CHUNK_SIZE,
            "dataset_from_index": self.frames,
            "dataset_to_index": self.frames + length,
        }
        self.episodes += 1
        self.frames += length
        return where, stats

    def close(self) -> None:
        if self._parquet is not None:
            self._parquet.close()

    @property
    def stats(self) -> dict[str, Stats]:
        """Statistics of each column over all episodes."""
        return _stats((key, np.concatenate(parts)) for key, parts in self._columns.items())

    def _columns_of(
        self, features: Mapping[str, NDArray], length: int, task_index: int
    ) -> dict[str, NDArray]:
        return {
            **{key: features[key] for key in self._keys},
            "timestamp": (np.arange(length) / self._fps).astype(np.float32),
            "frame_index": np.arange(length),
            "episode_index": np.full(length, self.episodes),
            "index": np.arange(self.frames, self.frames + length),
            "task_index": np.full(length, task_index),
        }

    def _write_row_group(self, columns: Mapping[str, NDArray]) -> None:
        """One row group for each episode, as LeRobot has it."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        size = sum(values.nbytes for values in columns.values())
        if self._parquet is not None and self._bytes + size > MAX_BYTES:
            self._parquet.close()
            self._parquet = None
        if self._parquet is None:
            path = self._root / DATA_PATH.format(
                chunk_index=self._files // CHUNK_SIZE, file_index=self._files % CHUNK_SIZE
            )
            path.parent.mkdir(parents=True, exist_ok=True)
            self._parquet = pq.ParquetWriter(
                path, schema=self._schema, compression="snappy", use_dictionary=True
            )
            self._files, self._bytes = self._files + 1, 0
        arrays = [_arrow(columns[field.name], field.type) for field in self._schema]
        self._parquet.write_table(pa.Table.from_arrays(arrays, schema=self._schema))
        self._bytes += size


def _stats(columns: Iterable[tuple[str, NDArray]]) -> dict[str, Stats]:
    return {key: vector_stats(values) for key, values in columns}


def _arrow(values: NDArray, type: pa.DataType) -> pa.Array:
    import pyarrow as pa

    if pa.types.is_fixed_size_list(type):
        flat = pa.array(np.ascontiguousarray(values).reshape(-1), type.value_type)
        return pa.FixedSizeListArray.from_arrays(flat, type=type)
    return pa.array(values, type)
