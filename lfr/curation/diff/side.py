"""One of two datasets that are compared: its episodes, their rows and their words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lfr.curation.checks.counts import task_words
from lfr.curation.contents import EPISODES, Contents, runs
from lfr.curation.diff.fingerprints import Hashes, is_numeric, numbers, row_hashes, text_hash
from lfr.curation.finding import readable, unreadable
from lfr.data.features import names_of
from lfr.errors import DataError

Rows = NDArray[np.int64]
BATCH, FEW = 8192, 64  # rows that are read at once: of numbers, and of pictures or words


@dataclass
class Side:
    """A dataset whose episodes have been found; a position is a row of meta/episodes.

    Attributes:
        contents: the dataset.
        episode: (E,) episode_index.
        start: (E,) the first row of each, over the rows of all files.
        length: (E,) rows.
        hashes: (N,) of the rows of the columns that are compared.
    """

    contents: Contents
    episode: Rows
    start: Rows
    length: Rows
    hashes: dict[str, Hashes] = field(default_factory=dict)

    @classmethod
    def open(cls, path: Path) -> Side:
        """Raises DataError: there is no dataset, or one that cannot be read."""
        with readable(path):
            contents = Contents.open(path)
            contents.source.fetch("data")
            _ = contents.features
            episode, length = contents.episode_column("episode_index"), contents.lengths
            if {episode.dtype.kind, length.dtype.kind} - {
                "i",
                "u",
            } or episode.ndim + length.ndim > 2:
                raise DataError("episodes whose index or length is no whole number",
                                file=path / EPISODES)  # fmt: skip
            if len(set(episode.tolist())) < len(episode):
                raise DataError("an episode is there twice; see lfr verify", file=path / EPISODES)
            start = np.zeros(len(episode), np.int64)
            there = runs(contents) if length.any() else None
        run_of = {} if there is None else {int(e): r for r, e in enumerate(there.episode)}
        for position, (index, rows) in enumerate(
            zip(episode.tolist(), length.tolist(), strict=True)
        ):
            run = run_of.get(index)
            found = 0 if run is None or there is None else int(there.length[run])
            if found != rows:
                raise DataError(
                    "another number of rows than the episode's length; see lfr verify", file=path,
                    episode=index, found=found, expected=rows,
                )  # fmt: skip
            if run is not None and there is not None:
                start[position] = there.start[run]
        return cls(contents, episode.astype(np.int64), start, length.astype(np.int64))

    @property
    def path(self) -> Path:
        return self.contents.path

    @property
    def name(self) -> Path:
        """What whoever asked for it called it."""
        return Path(self.contents.source.name)

    def __len__(self) -> int:
        return len(self.episode)

    def rows(self, position: int) -> slice:
        first = int(self.start[position])
        return slice(first, first + int(self.length[position]))

    @cached_property
    def of_row(self) -> Rows:
        """(N,) the position of each row's episode; -1 of none."""
        found = np.full(self._count, -1)
        for position in range(len(self)):
            found[self.rows(position)] = position
        return found

    @property
    def _count(self) -> int:
        return sum(self.contents.rows_of_files) if self.length.any() else 0

    @cached_property
    def columns(self) -> list[str]:
        """Of the rows, in the order of the first file."""
        if not self._count:
            return []
        with readable(self.path):
            return list(self.contents.schemas[0].names)

    def batches(self, column: str) -> Iterator[pa.Array]:
        """A column of all rows, some rows at a time."""
        with readable(self.path):
            files = zip(self.contents.data_files, self.contents.footers, strict=True)
            for path, footer in files:
                where: dict[str, Any] = {"file": self.contents.relative(path), "column": column}
                with unreadable("damaged-file", "its rows cannot be read", pa.ArrowException,
                                OSError, KeyError, IndexError, **where), \
                        pq.ParquetFile(path, metadata=footer) as file:  # fmt: skip
                    if column not in file.schema_arrow.names:
                        raise KeyError("no such column")
                    kind = file.schema_arrow.field(column).type
                    size = BATCH if is_numeric(kind) else FEW
                    for batch in file.iter_batches(size, columns=[column], use_threads=False):
                        if len(batch):
                            yield batch.column(column)

    def size(self, column: str) -> int | None:
        """How many numbers each row of a column has, by its first rows; None where it has none."""
        first = next(self.batches(column), None)
        values = None if first is None else numbers(first.drop_null())
        return None if values is None else values.shape[1]

    def names(self, column: str, size: int) -> list[str]:
        """What a column's dimensions are called; their numbers where info.json does not say."""
        names = names_of(self.contents.features.get(column, {}))
        return names if len(names) == size else [str(i) for i in range(size)]

    def read_hashes(self, column: str, dims: Sequence[int] | None) -> bool:
        """Fill `hashes` with those of some of a column's dimensions; None are all.

        Returns:
            Whether all of its rows are as many numbers.
        """
        found: list[Hashes] = [np.zeros(0, np.uint64)]
        sizes: set[int] = set()
        with readable(self.path), unreadable("schema", "values that cannot be read", ValueError,
                                             file="data", column=column):  # fmt: skip
            for batch in self.batches(column):
                found.append(row_hashes(batch, dims))
                values = numbers(batch)
                sizes.add(-1 if values is None else values.shape[1])
        self.hashes[column] = np.concatenate(found)
        return len(sizes) == 1 and min(sizes) >= 0

    def values(self, column: str, dims: Sequence[int] | None) -> Iterator[NDArray]:
        """(n, D) numbers of a column whose rows are as many numbers, some rows at a time.

        Raises:
            DataError: some are no numbers.
        """
        for batch in self.batches(column):
            values = numbers(batch)
            if values is None:
                raise DataError("no numbers; see lfr verify", file=self.path / "data",
                                column=column)  # fmt: skip
            yield values if dims is None else values[:, list(dims)]

    def all_values(self, column: str, dims: Sequence[int] | None) -> NDArray:
        """(N, D) of the same."""
        return np.concatenate(list(self.values(column, dims)))

    @cached_property
    def words(self) -> Hashes:
        """(N,) hashes of the words of each row's task, whatever its number."""
        return self._words[0]

    def said(self, position: int) -> str:
        """The words of an episode's tasks, in the order in which they come."""
        _, texts, number = self._words
        return " / ".join(texts[n] for n in dict.fromkeys(number[self.rows(position)].tolist()))

    @cached_property
    def _words(self) -> tuple[Hashes, list[str], Rows]:
        if not self._count:
            return np.zeros(0, np.uint64), [], np.zeros(0, np.int64)
        with readable(self.path), unreadable("schema", "words that cannot be read", ValueError,
                                             file="meta/tasks.parquet"):  # fmt: skip
            known = task_words(self.contents)
            index = self.contents.column("task_index").reshape(self._count)
        tasks, number = np.unique(index, return_inverse=True)
        texts = [str(known.get(task, "(no words)")) for task in tasks.tolist()]
        of_task = np.array([text_hash(text) for text in texts], np.uint64)
        return of_task[number], texts, number
