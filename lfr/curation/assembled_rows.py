"""The rows of a new dataset: those of chosen episodes, numbered anew, file by file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lfr.curation.checks.counts import task_words
from lfr.curation.contents import TASKS, runs, with_column
from lfr.curation.finding import readable, unreadable
from lfr.curation.parts import Source, files_per_chunk, new_file
from lfr.errors import DataError

MEGABYTES = 100  # of one Parquet file, where info.json does not say; LeRobot's own default


@dataclass(frozen=True)
class Rows:
    """What has been written.

    Attributes:
        places: columns of meta/episodes that say in which file each episode is.
        tasks: words -> task_index, in the order of first use.
    """

    places: dict[str, NDArray[np.int64]]
    tasks: dict[str, int] = field(default_factory=dict)


def write_rows(out: Path, sources: Sequence[Source]) -> Rows:
    """Write the data files of a new dataset at `out`, one row group for each episode.

    Raises:
        DataError: rows that cannot be read, or that are not those of the episode.
    """
    model = sources[0].contents
    said = model.info.get("data_files_size_in_mb")
    limit = (said if isinstance(said, int | float) and said > 0 else MEGABYTES) * 2**20
    tasks: dict[str, int] = {}
    writer: pq.ParquetWriter | None = None
    files, size, start = 0, 0, 0
    places: list[tuple[int, int]] = []
    try:
        for episode, rows in enumerate(_episodes(sources, tasks)):
            rows = with_column(rows, "episode_index", np.full(len(rows), episode))
            rows = with_column(rows, "index", np.arange(start, start + len(rows)))
            if writer is None or size + rows.nbytes > limit:
                if writer is not None:
                    writer.close()
                path = new_file(out, model, "data_path", files)
                writer = pq.ParquetWriter(path, rows.schema, compression="snappy")
                files, size = files + 1, 0
            writer.write_table(rows, row_group_size=max(len(rows), 1))
            size, start = size + rows.nbytes, start + len(rows)
            places.append(divmod(files - 1, files_per_chunk(model)))
    finally:
        if writer is not None:
            writer.close()
    chunk, file = np.array(places).T
    return Rows({"data/chunk_index": chunk, "data/file_index": file}, tasks)


def _episodes(sources: Sequence[Source], tasks: dict[str, int]) -> Iterator[pa.Table]:
    """The rows of each episode, in the columns and types of the first dataset's first file."""
    with readable(sources[0].path):
        schema = sources[0].contents.schemas[0]
    for source in sources:
        with readable(source.path):
            yield from _episodes_of(source, schema, tasks)


def _episodes_of(source: Source, schema: pa.Schema, tasks: dict[str, int]) -> Iterator[pa.Table]:
    contents = source.contents
    there, words = runs(contents), task_words(contents)
    run_of = dict(zip(there.episode.tolist(), range(len(there.episode)), strict=True))
    ends = np.cumsum(contents.rows_of_files)
    open_file, table = -1, pa.table({})
    for episode, length in zip(source.episodes, source.lengths.tolist(), strict=True):
        run = run_of.get(episode)
        if run is None or there.length[run] != length:
            raise DataError("another number of rows than the episode's length", file=source.path,
                            episode=episode, found=0 if run is None else int(there.length[run]),
                            expected=length)  # fmt: skip
        start = int(there.start[run])
        file = int(np.searchsorted(ends, start, side="right"))
        if file != open_file:
            path = contents.data_files[file]
            table, open_file = contents.rows_of(path), file
            for name in schema.names:
                if name not in table.column_names:
                    raise DataError("a column is missing", file=path, column=name)
        first = start - (int(ends[file]) - contents.rows_of_files[file])
        rows = table.slice(first, length).select(schema.names)
        with unreadable("dtype", "rows of another type than the first dataset's",
                        pa.ArrowException, ValueError, file=contents.relative(path)):  # fmt: skip
            rows = rows.cast(schema)
        numbers = rows["task_index"].to_pylist()
        if unknown := set(numbers) - set(words):
            raise DataError("a task without words", file=source.path / TASKS, episode=episode,
                            found=min(unknown), expected=sorted(words))  # fmt: skip
        new = [tasks.setdefault(words[number], len(tasks)) for number in numbers]
        yield with_column(rows, "task_index", np.array(new))
