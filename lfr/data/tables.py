"""The files of a LeRobot v3.0 dataset, read with pyarrow alone."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lfr.artifacts import files_below, read_json
from lfr.data.source import VERSION, Source, source_of
from lfr.data.templates import file_name
from lfr.errors import DataError

Row = dict[str, Any]
"""What meta/episodes says of one episode."""


@dataclass(frozen=True)
class DatasetFiles:
    """A dataset's folder, its info.json, and its Parquet files opened on demand."""

    path: Path
    info: dict[str, Any]
    source: Source

    @classmethod
    def open(cls, path: Path) -> DatasetFiles:
        """Open the dataset at `path`.

        Raises:
            DataError: there is no LeRobot v3.0 dataset, or its info.json describes no features; of
                v2.1 it says what converts it.
        """
        path = Path(path)
        file = path / "meta" / "info.json"
        if not path.is_dir():
            raise DataError("no such dataset; pack its logs first", file=path)
        if not file.is_file():
            raise DataError("not a LeRobot dataset", file=file, found="no such file")
        info = read_json(file)
        version = info.get("codebase_version") if isinstance(info, dict) else None
        if version != VERSION or is_older(path):
            raise other_format(path, version)
        features = info.get("features")
        if not isinstance(features, dict) or not all(map(_is_described, features.values())):
            raise DataError("no features, each with a dtype and a shape", file=file,
                            column="features")  # fmt: skip
        return cls(path, info, source_of(path))

    @property
    def features(self) -> dict[str, dict[str, Any]]:
        return self.info["features"]

    @property
    def fps(self) -> float:
        """Frames per second. Raises DataError where info.json does not say it."""
        fps = self.info.get("fps")
        if isinstance(fps, bool) or not isinstance(fps, int | float) or not 0 < fps < 1e9:
            file = self.path / "meta" / "info.json"
            raise DataError("no frames per second", file=file, column="fps", found=f"{fps!r:.40}",
                            expected="a positive number")  # fmt: skip
        return fps

    @cached_property
    def episodes(self) -> pa.Table:
        """meta/episodes, without its statistics: one row for each episode, in no order.

        What one of its files has and another has not is missing (null) in the other's episodes.
        """
        files = self.files("meta/episodes")
        tables = []
        for file in files:
            names = [n for n in _schema(file).names if not n.startswith("stats/")]
            tables.append(_read(file, names).replace_schema_metadata())
        try:
            table = pa.concat_tables(tables, promote_options="permissive")
        except (pa.ArrowInvalid, pa.ArrowTypeError) as error:
            raise DataError(
                "its files have columns of different types", file=self.path / "meta/episodes",
                found=str(error).splitlines()[0],
            ) from error  # fmt: skip
        for column in ("episode_index", "length"):
            if column not in table.column_names:
                raise DataError("a column is missing", file=files[0], column=column)
        return table

    def episode(self, index: int) -> Row:
        """What meta/episodes says of the episode of this index, whichever row that is.

        Raises:
            DataError: there is no such episode.
        """
        known = self.episodes["episode_index"].to_pylist()
        if index not in known:
            expected = f"{min(known)} to {max(known)}" if known else "none"
            raise DataError("no such episode", file=self.path, episode=index, expected=expected)
        return self.episodes.slice(known.index(index), 1).to_pylist()[0]

    def file_of(self, row: Row, prefix: str) -> Path:
        """Where the rows or pictures of an episode lie, by its row of meta/episodes.

        Args:
            prefix: "data", or "videos/<feature>".

        Raises:
            DataError: the row does not say it, or info.json has no such path.
        """
        where = {}
        for name in ("chunk_index", "file_index"):
            column = f"{prefix}/{name}"
            value = row.get(column)
            if value is None or value != value or int(value) != value:
                raise DataError(
                    "meta/episodes does not say in which file an episode lies", file=self.path,
                    episode=row["episode_index"], column=column,
                    found="no such column" if column not in row else value,
                    expected="a whole number",
                )  # fmt: skip
            where[name] = int(value)
        kind, _, key = prefix.partition("/")
        template = "data_path" if kind == "data" else "video_path"
        try:
            name = file_name(self.info.get(template), video_key=key, **where)
        except ValueError as error:
            raise DataError("no such path", file=self.path / "meta/info.json", column=template,
                            found=error) from error  # fmt: skip
        self.source.fetch(name)
        return self.path / name

    def number(self, row: Row, column: str) -> float:
        """A number of meta/episodes' row of an episode.

        Raises:
            DataError: the row does not have it.
        """
        value = row.get(column)
        if not isinstance(value, int | float) or value != value:
            raise DataError(
                "meta/episodes does not say it of an episode", file=self.path,
                episode=row["episode_index"], column=column,
                found="no such column" if column not in row else value, expected="a number",
            )  # fmt: skip
        return float(value)

    def rows_of(self, row: Row) -> pa.Table:
        """An episode's rows, from the file that meta/episodes names, or wherever else they lie.

        Raises:
            DataError: there are none; a file is missing or cut off.
        """
        index = row["episode_index"]
        wanted = pc.field("episode_index") == index
        try:
            named = [self.file_of(row, "data")]
        except DataError:  # then they are looked for
            named = []
        for file in self._named_and_others(named):
            if file in named and not file.is_file():
                raise DataError("a file of rows is missing", file=file, episode=index)
            try:  # of a file that has a row group for each episode, one group is read
                table = pq.read_table(file, filters=wanted, partitioning=None)  # pyright: ignore[reportArgumentType]
            except (pa.ArrowInvalid, OSError) as error:
                raise _cut_off(file, error) from error
            if len(table):
                return table
        raise DataError("an episode without rows", file=self.path / "data", episode=index)

    def _named_and_others(self, named: list[Path]) -> Iterator[Path]:
        yield from named
        yield from (file for file in self.files("data") if file not in named)

    def data(self, columns: Sequence[str]) -> pa.Table:
        """The rows of all episodes.

        Raises:
            DataError: a file is cut off, or lacks a column.
        """
        return pa.concat_tables([_read(file, columns) for file in self.files("data")])

    def files(self, folder: str) -> list[Path]:
        """The Parquet files of a folder, in order. Raises DataError when there are none."""
        self.source.fetch(folder)
        files = files_below(self.path / folder, ".parquet")
        if not files:
            raise DataError("no Parquet files; pack the logs again", file=self.path / folder)
        return files

    def task_names(self) -> list[str]:
        """Names of the tasks recorded, where the dataset has this project's column of them."""
        if "task_name" not in self.episodes.column_names:
            return []
        return sorted({name for name in self.episodes["task_name"].to_pylist() if name})


def is_older(path: Path) -> bool:
    """Whether a dataset that calls itself v3.0 has the files of v2.1: info.json was edited."""
    meta = path / "meta"
    return (meta / "episodes.jsonl").is_file() and not (meta / "episodes").is_dir()


def _is_described(feature: object) -> bool:
    if not isinstance(feature, dict) or not isinstance(feature.get("dtype"), str):
        return False
    shape = feature.get("shape")
    return isinstance(shape, list) and all(isinstance(size, int) for size in shape)


def other_format(path: Path, version: object) -> DataError:
    """What is said of the LeRobot dataset at `path`, which is of another version than VERSION."""
    message = "another LeRobot format"
    if not is_older(path) and (path / "meta" / "episodes").is_dir():
        message += f" by its name alone, with the files of {VERSION}; correct info.json"
    elif is_older(path) or str(version).startswith("v2."):
        message += f"; for all but verify, view and columns convert it with: {conversion(path)}"
        if version == VERSION:  # what it says, and not what it is
            version = f"{version}, and meta/episodes.jsonl of v2.1; set it to v2.1 first"
    return DataError(message, file=path / "meta" / "info.json", found=version, expected=VERSION)


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
