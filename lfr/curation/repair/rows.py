"""The rows' own numbers: index, episode_index, frame_index, and the order that they tell."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lfr.curation.contents import Contents, with_column
from lfr.curation.finding import unreadable
from lfr.curation.repair.draft import Draft, Unmendable
from lfr.curation.repair.episode_rows import counted, match, read_episodes, refuse_lost_rows

Ints = NDArray[np.int64]
CODECS = ("snappy", "gzip", "zstd", "brotli")


@dataclass(frozen=True)
class Numbers:
    """What the rows' numbers are, or should be.

    Attributes:
        episode, frame, index: (N,) each.
        starts: (E,) first row of each episode.
        order: (N,) which row of the files is each, where they have to be put in another order.
    """

    episode: Ints
    frame: Ints
    index: Ints
    starts: Ints
    order: Ints | None = None

    @property
    def lengths(self) -> Ints:
        return np.diff(self.starts, append=len(self.index))

    def columns(self) -> dict[str, Ints]:
        return {"index": self.index, "frame_index": self.frame, "episode_index": self.episode}


def mend_rows(draft: Draft) -> None:
    """Number the rows anew, where it is plain which rows are which.

    Raises:
        Unmendable: it is not, or rows have been lost or are there twice.
    """
    contents = draft.contents()
    found, wanted = _found(contents), numbers(contents)
    table = read_episodes(contents)[0]
    if table is not None:
        refuse_lost_rows(contents, table, match(table, wanted.lengths), wanted.lengths)
    order = wanted.order
    end = 0
    for file, count in zip(contents.data_files, contents.rows_of_files, strict=True):
        part, end = slice(end, end + count), end + count
        name = contents.relative(file)
        if order is None:
            moved = np.zeros(count, bool)
        else:
            moved = order[part] != np.arange(part.start, part.stop)
        before = {k: v[part] if order is None else v[order[part]] for k, v in found.items()}
        after = {key: values[part] for key, values in wanted.columns().items()}
        wrong = {key: int((before[key] != after[key]).sum()) for key in after}
        if not moved.any() and not any(wrong.values()):
            continue
        with draft.replaced(name) as new:
            rows = order[part] - part.start if order is not None and moved.any() else None
            changed = {key: after[key] for key, places in wrong.items() if places}
            _rewrite(contents, file, new, changed, rows)
        if moved.any():
            draft.mended(name, "rows put in the order of their index", int(moved.sum()), "row")
        for key, places in wrong.items():
            if places:
                draft.mended(name, f"{key} counted anew", places, "row")


def episode_lengths(contents: Contents) -> Ints:
    """(E,) rows of each episode, where the rows are numbered as they should be.

    Raises:
        Unmendable: they are not.
    """
    wanted = numbers(contents)
    found = _found(contents)
    if any((found[key] != values).any() for key, values in wanted.columns().items()):
        raise Unmendable  # said where they are numbered
    return wanted.lengths


def numbers(contents: Contents) -> Numbers:
    """What the rows' numbers should be.

    Raises:
        Unmendable: that is not plain.
    """
    found = _found(contents)
    seconds = contents.column("timestamp").astype(np.float64).ravel()
    count = len(seconds)
    if not count:
        raise Unmendable("there are no rows")
    order = _by_index(contents, found["index"])
    if order is not None:
        sorted_ = {key: values[order] for key, values in found.items()}
        starts = _starts(sorted_, seconds[order], None)
        if starts is not None:
            wanted = _counted(starts, count, order)
            same = all((sorted_[k] == v).all() for k, v in wanted.columns().items())
            if same and _standing(starts, seconds[order]) is None:
                return wanted
    starts = _starts(found, seconds, counted(contents))
    if starts is None:
        raise Unmendable(
            "the rows' numbers: episode_index, frame_index and timestamps do not tell the same "
            "episodes, so that it is not certain which rows are whose"
        )
    wanted = _counted(starts, count)
    changed = any((found[key] != values).any() for key, values in wanted.columns().items())
    row = _standing(starts, seconds) if changed else None
    if row is not None:
        place = contents.place(row)
        raise Unmendable(
            f"the rows' numbers: time stands still or goes back within an episode, and new ones "
            f"would hide it: {place['file']}, episode {place['episode']}, row {row}"
        )
    return wanted


def _found(contents: Contents) -> dict[str, Ints]:
    names = ("index", "frame_index", "episode_index")
    return {name: contents.column(name).ravel() for name in names}


def _counted(starts: Ints, count: int, order: Ints | None = None) -> Numbers:
    lengths = np.diff(starts, append=count)
    index = np.arange(count)
    episode = np.repeat(np.arange(len(starts)), lengths)
    return Numbers(episode, index - np.repeat(starts, lengths), index, starts, order)


def _starts(found: dict[str, Ints], seconds: NDArray, counted: Ints | None) -> Ints | None:
    """(E,) first rows of the episodes; None where the columns do not agree on them.

    Args:
        counted: (E,) how many rows meta/episodes says they have; None where it says nothing.
    """
    episode, frame = found["episode_index"], found["frame_index"]
    by_time = np.flatnonzero(np.diff(seconds, prepend=np.inf) <= 0)
    by_frame = np.flatnonzero(frame == 0)
    by_episode = np.flatnonzero(np.diff(episode, prepend=episode[:1] - 1))
    if np.array_equal(episode[by_episode], np.arange(len(by_episode))) and (
        np.array_equal(by_episode, by_frame) or np.array_equal(by_episode, by_time)
    ):
        return by_episode
    if not len(by_frame) or by_frame[0] or not np.array_equal(by_frame, by_time):
        return None
    lengths = np.diff(by_frame, append=len(frame))
    if (frame != np.arange(len(frame)) - np.repeat(by_frame, lengths)).any():
        return None
    if counted is not None and not np.array_equal(counted, lengths):
        return None
    return None if _changed_places(episode, by_frame) else by_frame


def _changed_places(episode: Ints, starts: Ints) -> bool:
    """Whether an episode is called by another one's number, and that one is not."""
    called = np.array([np.bincount(np.unique(part, return_inverse=True)[1]).argmax()
                       for part in np.split(episode, starts[1:])])  # fmt: skip
    called = np.array([np.unique(part)[most] for part, most in
                       zip(np.split(episode, starts[1:]), called, strict=True)])  # fmt: skip
    if (np.diff(called) > 0).all():
        return False
    known = (called >= 0) & (called < len(called)) & (called != np.arange(len(called)))
    others = called[known]
    return bool((called[others] != others).any())


def _standing(starts: Ints, seconds: NDArray) -> int | None:
    """The first row within an episode whose time does not rise."""
    rises = np.diff(seconds, prepend=-np.inf) > 0
    rises[starts] = np.isfinite(seconds[starts])
    return None if rises.all() else int(np.argmin(rises))


def _by_index(contents: Contents, index: Ints) -> Ints | None:
    """The order of `index`, where it numbers all rows, none in another file, in another order."""
    order = np.argsort(index, kind="stable")
    every = np.arange(len(index))
    if (index == every).all() or (index[order] != every).any():
        return None
    ends = np.cumsum(contents.rows_of_files)
    files = np.searchsorted(ends, every, side="right")
    return order if (files[order] == files).all() else None


def _rewrite(
    contents: Contents, file: Path, new: Path, columns: dict[str, Ints], rows: Ints | None
) -> None:
    """Write a file's rows with other columns, in other order, in the row groups that it has."""
    opened = contents.opened(file)
    groups = opened.metadata.num_row_groups
    codec = opened.metadata.row_group(0).column(0).compression.lower() if groups else "snappy"
    where: dict[str, Any] = {"file": contents.relative(file)}
    with unreadable("damaged-file", "its rows cannot be read or written", pa.ArrowException,
                    OSError, **where):  # fmt: skip
        whole = None if rows is None else opened.read(use_threads=False).take(pa.array(rows))
        with pq.ParquetWriter(
            new, opened.schema_arrow, compression=codec if codec in CODECS else "snappy"
        ) as writer:
            start = 0
            for i in range(groups):
                size = opened.metadata.row_group(i).num_rows
                if whole is None:
                    part = opened.read_row_group(i, use_threads=False)
                else:
                    part = whole.slice(start, size)
                for name, values in columns.items():
                    part = with_column(part, name, values[start : start + size])
                writer.write_table(part, row_group_size=max(size, 1))
                start += size
