"""The files of a LeRobot v3.0 dataset, read with pyarrow alone."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lfr.artifacts import read_json
from lfr.errors import DataError

VERSION = "v3.0"


@dataclass(frozen=True)
class DatasetFiles:
    """A dataset's folder, its info.json, and its Parquet files opened on demand."""

    path: Path
    info: dict[str, Any]

    @classmethod
    def open(cls, path: Path) -> DatasetFiles:
        """Open the dataset at `path`.

        Raises:
            DataError: there is no LeRobot v3.0 dataset; of v2.1 it says what converts it.
        """
        path = Path(path)
        file = path / "meta" / "info.json"
        if not path.is_dir():
            raise DataError("no such dataset; pack its logs first", file=path)
        if not file.is_file():
            raise DataError("not a LeRobot dataset", file=file, found="no such file")
        info = read_json(file)
        version = info.get("codebase_version") if isinstance(info, dict) else None
        if version != VERSION:
            raise other_format(path, version)
        return cls(path, info)

    @property
    def features(self) -> dict[str, dict[str, Any]]:
        return self.info["features"]

    @cached_property
    def episodes(self) -> pa.Table:
        """meta/episodes, without its statistics: one row for each episode."""
        files = self.files("meta/episodes")
        tables = []
        for file in files:
            names = [n for n in _schema(file).names if not n.startswith("stats/")]
            tables.append(_read(file, names))
        table = pa.concat_tables(tables)
        for column in ("episode_index", "length"):
            if column not in table.column_names:
                raise DataError("a column is missing", file=files[0], column=column)
        return table

    def data(self, columns: Sequence[str]) -> pa.Table:
        """The rows of all episodes.

        Raises:
            DataError: a file is cut off, or lacks a column.
        """
        return pa.concat_tables([_read(file, columns) for file in self.files("data")])

    def files(self, folder: str) -> list[Path]:
        """The Parquet files of a folder, in order. Raises DataError when there are none."""
        files = sorted((self.path / folder).glob("*/*.parquet"))
        if not files:
            raise DataError("no Parquet files; pack the logs again", file=self.path / folder)
        return files

    def task_names(self) -> list[str]:
        """Names of the tasks recorded, where the dataset has this project's column of them."""
        if "task_name" not in self.episodes.column_names:
            return []
        return sorted({name for name in self.episodes["task_name"].to_pylist() if name})


def other_format(path: Path, version: object) -> DataError:
    """What is said of the LeRobot dataset at `path`, which is of another version than VERSION."""
    return DataError(
        f"another LeRobot format; convert it in place with: {conversion(path)}",
        file=path / "meta" / "info.json",
        found=version,
        expected=VERSION,
    )


def conversion(path: Path) -> str:
    """LeRobot's own command that makes a v2.1 dataset a v3.0 one.

    It would push the result to the Hub unless told not to, and it leaves what was there beside it
    as `<name>_old`.
    """
    folder = path.resolve()
    return shlex.join(
        ["python", "-m", "lerobot.scripts.convert_dataset_v21_to_v30",
         f"--repo-id=local/{folder.name}", f"--root={folder}", "--push-to-hub=false"]
    )  # fmt: skip


def values(table: pa.Table, column: str) -> NDArray:
    """A column as (N,) or, for a vector feature, (N, D).

    Raises:
        TypeError: the column is neither scalars nor lists of one length.
        ValueError: it has nulls, or lists of different lengths.
    """
    array = table[column].combine_chunks()
    if array.null_count:
        raise ValueError(f"{array.null_count} missing values")
    if pa.types.is_fixed_size_list(array.type):
        return _flat(array).reshape(len(array), array.type.list_size)
    if pa.types.is_list(array.type) or pa.types.is_large_list(array.type):  # files by other tools
        lengths = set(np.diff(array.offsets.to_numpy()).tolist())
        if len(lengths) != 1:
            raise ValueError(f"lists of lengths {sorted(lengths)}")
        return _flat(array).reshape(len(array), lengths.pop())
    if pa.types.is_integer(array.type) or pa.types.is_floating(array.type):
        return array.to_numpy()
    if pa.types.is_boolean(array.type):
        return array.to_numpy(zero_copy_only=False)
    raise TypeError(f"{array.type} values")


def _flat(array: Any) -> NDArray:
    flat = array.flatten()
    if flat.null_count:
        raise ValueError(f"{flat.null_count} missing values")
    return flat.to_numpy(zero_copy_only=False)


def _schema(file: Path) -> pa.Schema:
    try:
        return pq.read_schema(file)
    except (pa.ArrowInvalid, OSError) as error:
        raise _cut_off(file, error) from error


def _read(file: Path, columns: Sequence[str]) -> pa.Table:
    present = _schema(file).names
    for column in columns:
        if column not in present:
            raise DataError(
                "a column is missing",
                file=file,
                column=column,
                found=", ".join(present),
                expected=column,
            )
    try:
        return pq.ParquetFile(file).read(columns=list(columns))
    except (pa.ArrowInvalid, OSError) as error:
        raise _cut_off(file, error) from error


def _cut_off(file: Path, error: Exception) -> DataError:
    reason = str(error).splitlines()[0]
    return DataError(
        "a cut-off or damaged Parquet file; pack the logs again",
        file=file,
        found=reason,
        expected="a whole Parquet file",
    )
