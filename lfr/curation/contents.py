"""A dataset's folder as it is, right or wrong: read once, whole columns at a time, with pyarrow."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lfr.artifacts import files_below, parse_json
from lfr.curation.finding import Finding, Unreadable, unreadable
from lfr.data import layout, tables
from lfr.data.features import shape_of
from lfr.data.source import VERSION, Source, source_of
from lfr.data.tables import is_older, other_format
from lfr.data.templates import file_name
from lfr.errors import DataError

INFO = "meta/info.json"
STATS = "meta/stats.json"
TASKS = "meta/tasks.parquet"
EPISODES = "meta/episodes"
DEFAULT_FEATURES = tuple(layout.DEFAULT_FEATURES)
PICTURES = ("video", "image")  # dtypes of features that are not numbers
NOT_NUMBERS = (*PICTURES, "string", "language")


@dataclass
class Contents:
    """What a dataset's folder holds. A part that cannot be read raises `Unreadable`, each time.

    Attributes:
        path: the dataset's folder.
        info: meta/info.json.
        source: where it came from.
    """

    path: Path
    info: dict[str, Any]
    source: Source
    _columns: dict[str, NDArray] = field(default_factory=dict)

    @classmethod
    def open(cls, path: Path) -> Contents:
        """Open the LeRobot v3.0 dataset at `path`.

        Raises:
            DataError: there is none.
            Unreadable: there is one, and its info.json is cut off.
        """
        path = Path(path)
        file = path / INFO
        if not path.is_dir():
            raise DataError("no such dataset", file=path)
        if not file.is_file():
            raise DataError("not a LeRobot dataset", file=file, found="no such file")
        what = "cut off or no JSON object"
        with unreadable("info", what, ValueError, file=INFO):
            info = parse_json(file.read_text(encoding="utf-8"))
            if not isinstance(info, dict):
                raise ValueError(type(info).__name__)
        if info.get("codebase_version") != VERSION or is_older(path):
            raise other_format(path, info.get("codebase_version"))
        return cls(path, info, source_of(path))

    @property
    def features(self) -> dict[str, dict[str, Any]]:
        found = self.info.get("features")
        if not isinstance(found, dict) or not all(isinstance(f, dict) for f in found.values()):
            raise Unreadable(Finding("info", "no features", file=INFO, column="features"))
        return found

    @cached_property
    def fps(self) -> float:
        fps = self.info.get("fps")
        if isinstance(fps, bool) or not isinstance(fps, int | float) or not 0 < fps < 1e9:
            raise Unreadable(
                Finding("info", "no frames per second", file=INFO, column="fps", found=fps,
                        expected="a positive number")
            )  # fmt: skip
        return fps

    def numeric(self) -> list[str]:
        """Features whose values are vectors of numbers, or one number: what statistics are of."""
        return [
            key
            for key, feature in self.features.items()
            if feature.get("dtype") not in NOT_NUMBERS and len(shape_of(feature)) == 1
        ]

    def pictures(self, dtype: str = "video") -> list[str]:
        return [key for key, feature in self.features.items() if feature.get("dtype") == dtype]

    def named(self, template: str, **indices: Any) -> str:
        """A file by the format string of info.json called `template`, relative to the folder.

        Raises:
            Unreadable: it is no format string, or names a place outside of the folder.
        """
        with unreadable("info", "no such path", ValueError, file=INFO, column=template):
            name = file_name(self.info.get(template), **indices)
        place = PurePosixPath(name)
        if place.is_absolute() or ".." in place.parts:
            raise Unreadable(Finding("info", "a path that leads out of the dataset", file=INFO,
                                     column=template, found=name))  # fmt: skip
        return name

    def relative(self, file: Path) -> str:
        # not `relative_to`, which takes longer than reading one of thousands of small files
        return file.as_posix().removeprefix(f"{self.path.as_posix()}/")

    @cached_property
    def episode_files(self) -> list[Path]:
        return files_below(self.path / EPISODES, ".parquet")

    @cached_property
    def episodes(self) -> pa.Table:
        """meta/episodes with its statistics, in the order of the files: one row per episode."""
        if not self.episode_files:
            raise Unreadable(Finding("missing-file", "no table of episodes", file=EPISODES))
        found = [self.rows_of(file) for file in self.episode_files]
        with unreadable("schema", "its files have different columns", pa.ArrowInvalid,
                        pa.ArrowTypeError, file=EPISODES):  # fmt: skip
            table = pa.concat_tables(found, promote_options="default")
        for column in ("episode_index", "length"):
            if column not in table.column_names:
                raise Unreadable(
                    Finding("schema", "a column is missing", file=EPISODES, column=column)
                )
        return table

    def episode_column(self, name: str, positions: Sequence[int] | None = None) -> NDArray:
        """A column of meta/episodes as an array; lists of one length as (E, D).

        Args:
            positions: of the rows of meta/episodes that are wanted; None are all.
        """
        episodes = self.episodes
        if positions is not None:
            episodes = episodes.take(pa.array(list(positions), pa.int64()))
        if name not in episodes.column_names:
            raise Unreadable(Finding("schema", "a column is missing", file=EPISODES, column=name))
        with unreadable("schema", "gaps or mixed shapes", TypeError, ValueError, KeyError,
                        file=EPISODES, column=name):  # fmt: skip
            return tables.values(episodes, name)

    def placed(
        self, prefix: str, positions: Sequence[int] | None = None
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """chunk_index and file_index of the episodes' rows ("data") or pictures
        ("videos/<feature>").

        Raises:
            Unreadable: meta/episodes does not say it of one; the finding names it.
        """
        episodes = self.episodes
        if positions is not None:
            episodes = episodes.take(pa.array(list(positions), pa.int64()))
        found = []
        for name in ("chunk_index", "file_index"):
            column = f"{prefix}/{name}"
            where: dict[str, Any] = {"file": EPISODES, "column": column}
            what = "does not say in which file an episode lies"
            if column not in episodes.column_names:
                raise Unreadable(Finding("placement", what, found="no such column", **where))
            values = episodes[column].to_pylist()
            wrong = [i for i, v in enumerate(values)
                     if not isinstance(v, int | float) or v != v or v != int(v)]  # fmt: skip
            if wrong:
                raise Unreadable(
                    Finding("placement", what, episode=episodes["episode_index"][wrong[0]].as_py(),
                            found=str(values[wrong[0]]), expected="a whole number",
                            places=len(wrong), episodes=_known(episodes, wrong), **where)
                )  # fmt: skip
            found.append(np.array(values, np.int64))
        return found[0], found[1]

    def placed_in(self, prefix: str) -> dict[str, NDArray[np.int64]]:
        """File -> rows of meta/episodes of the episodes whose rows ("data") or pictures
        ("videos/<feature>") are said to lie in it.

        Raises:
            Unreadable: as `placed` and `named`.
        """
        pairs, place, counts = np.unique(
            np.stack(self.placed(prefix), axis=1), axis=0, return_inverse=True, return_counts=True
        )
        template, names = "data_path", {}
        if prefix != "data":
            template, names = "video_path", {"video_key": prefix.removeprefix("videos/")}
        rows = np.split(np.argsort(place.ravel(), kind="stable"), np.cumsum(counts)[:-1])
        files: dict[str, NDArray[np.int64]] = {}
        for (chunk, file), there in zip(pairs.tolist(), rows, strict=False):
            name = self.named(template, chunk_index=chunk, file_index=file, **names)
            files[name] = np.sort(np.concatenate([files.get(name, there[:0]), there]))
        return files

    def episodes_in(self, file: str) -> tuple[int, ...]:
        """The episodes whose rows are said to lie in a file; none where nothing says so."""
        with suppress(Unreadable):
            return tuple(self.placed_in("data").get(file, np.zeros(0, np.int64)).tolist())
        return ()

    @cached_property
    def lengths(self) -> NDArray[np.int64]:
        """(E,) rows of each episode, as meta/episodes has it."""
        return self.episode_column("length")

    @cached_property
    def data_files(self) -> list[Path]:
        """The Parquet files of rows, in the order of their names."""
        return files_below(self.path / "data", ".parquet")

    @cached_property
    def footers(self) -> list[pq.FileMetaData]:
        """Of the data files, which may be more than can be open at once."""
        if not self.data_files:
            raise Unreadable(Finding("missing-file", "no rows", file="data"))
        return [self.opened(file).metadata for file in self.data_files]

    @cached_property
    def schemas(self) -> list[pa.Schema]:
        """Of the data files."""
        return [footer.schema.to_arrow_schema() for footer in self.footers]

    @cached_property
    def rows_of_files(self) -> list[int]:
        """Rows of each data file, by its footer."""
        return [footer.num_rows for footer in self.footers]

    def column(self, key: str) -> NDArray:
        """A feature of all rows, (N,) or (N, D); what is asked for often is kept."""
        if key in self._columns:
            return self._columns[key]
        table = self.table([key])
        with unreadable("shape", "gaps or mixed shapes", TypeError, ValueError, file="data",
                        column=key):  # fmt: skip
            values = tables.values(table, key)
        if key in DEFAULT_FEATURES:
            self._columns[key] = values
        return values

    def table(self, columns: Sequence[str]) -> pa.Table:
        """These columns of all rows."""
        parts = []
        for name, footer, schema in zip(self.data_files, self.footers, self.schemas, strict=True):
            where: dict[str, Any] = {"file": self.relative(name), "column": ", ".join(columns)}
            missing = [column for column in columns if column not in schema.names]
            if missing:
                raise Unreadable(Finding("schema", "a column is missing", **where))
            with unreadable("damaged-file", "its rows cannot be read", pa.ArrowException, OSError,
                            **where), pq.ParquetFile(name, metadata=footer) as file:  # fmt: skip
                parts.append(file.read(columns=list(columns), use_threads=False))
        with unreadable("schema", "another type in another file", pa.ArrowException, file="data",
                        column=", ".join(columns)):  # fmt: skip
            return pa.concat_tables([part.replace_schema_metadata() for part in parts])

    def place(self, row: int) -> dict[str, Any]:
        """Where a row stands, for a finding: file, episode, row."""
        ends = np.cumsum(self.rows_of_files)
        file = self.data_files[int(np.searchsorted(ends, row, side="right"))]
        try:
            episode = int(self.column("episode_index")[row])
        except Unreadable:
            episode = None
        return {"file": self.relative(file), "episode": episode, "row": row}

    def at_rows(self, which: NDArray) -> tuple[int, dict[str, Any]]:
        """The first of some rows, and where all of them stand, for a finding: file, episode, row,
        places, episodes.

        Args:
            which: a mask (N,) of all rows, or their numbers; at least one.
        """
        rows = np.flatnonzero(which) if which.dtype == bool else which
        where = self.place(int(rows[0]))
        if where["episode"] is not None:
            episodes = np.unique(self.column("episode_index")[rows])
            where["episodes"] = tuple(episodes.tolist())
        return where["row"], {**where, "places": len(rows)}

    def opened(self, file: Path) -> pq.ParquetFile:
        """A Parquet file, its footer read."""
        if not file.is_file():
            raise Unreadable(Finding("missing-file", "not there", file=self.relative(file)))
        with unreadable("damaged-file", "unfinalized or cut-off Parquet", pa.ArrowException,
                        OSError, UnicodeDecodeError, file=self.relative(file)):  # fmt: skip
            return pq.ParquetFile(file)

    def rows_of(self, file: Path) -> pa.Table:
        """All of a Parquet file."""
        opened = self.opened(file)
        with unreadable("damaged-file", "its rows cannot be read", pa.ArrowException, OSError,
                        file=self.relative(file)):  # fmt: skip
            return opened.read(use_threads=False).replace_schema_metadata()


def at_episodes(which: NDArray) -> tuple[int, dict[str, Any]]:
    """The first of some episodes, and all of them, for a finding: episode, places, episodes.

    Args:
        which: a mask (E,) of all episodes, or their numbers; at least one.
    """
    episodes = np.flatnonzero(which) if which.dtype == bool else which
    first = int(episodes[0])
    every = tuple(np.unique(episodes).tolist())
    return first, {"episode": first, "places": len(episodes), "episodes": every}


@dataclass(frozen=True)
class Runs:
    """The rows as episodes, told from the column episode_index alone: (R,) each.

    `episode` its value, `start` the first row, `length` the number of rows.
    """

    episode: NDArray[np.int64]
    start: NDArray[np.int64]
    length: NDArray[np.int64]

    def of_rows(self, values: NDArray) -> NDArray:
        """(N,) for each row, what `values` (R,) has for its run."""
        return np.repeat(values, self.length)


def runs(contents: Contents) -> Runs:
    """Stretches of rows with one episode_index: one for each episode where all is well."""
    index = contents.column("episode_index")
    start = np.flatnonzero(np.diff(index, prepend=index[:1] - 1))
    length = np.diff(start, append=len(index))
    return Runs(index[start], start, length)


def _known(episodes: pa.Table, places: Sequence[int]) -> tuple[int, ...]:
    """What some rows of meta/episodes say of themselves, as far as it is whole numbers."""
    said = episodes["episode_index"].take(pa.array(places, pa.int64())).to_pylist()
    return tuple(sorted({index for index in said if isinstance(index, int)}))


def with_column(table: pa.Table, name: str, values: Any) -> pa.Table:
    """A table with a column put in its old place, in its old type; at the end, if it is new."""
    if name not in table.column_names:
        return table.append_column(name, pa.array(values))
    at = table.column_names.index(name)
    field = table.schema.field(at)
    array = values if isinstance(values, pa.Array) else pa.array(values)
    return table.set_column(at, field, array.cast(field.type))
