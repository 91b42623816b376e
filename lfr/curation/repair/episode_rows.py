"""Which row of meta/episodes is which episode's, and whether it counts the rows that are there."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from lfr.curation.contents import EPISODES, Contents
from lfr.curation.finding import Finding, Unreadable, unreadable
from lfr.curation.repair.draft import Unmendable

Ints = NDArray[np.int64]


def read_episodes(contents: Contents) -> tuple[pa.Table | None, list[str], Ints, list[str]]:
    """All of meta/episodes that can be read.

    Returns:
        The table, None where there is none; the names of the files that can be read; (R,) which of
        these each row is in; and the names of those that cannot be read.

    Raises:
        Unreadable: the files' columns are of different types.
    """
    tables, names, damaged = [], [], []
    for file in contents.episode_files:
        name = contents.relative(file)
        try:
            tables.append(contents.rows_of(file))
            names.append(name)
        except Unreadable:
            damaged.append(name)
    files = np.repeat(np.arange(len(tables)), [len(table) for table in tables])
    if not tables:
        return None, [], files, damaged
    with unreadable("schema", "its files have different columns", pa.ArrowInvalid,
                    pa.ArrowTypeError, file=EPISODES):  # fmt: skip
        table = pa.concat_tables(tables, promote_options="default")
    if "episode_index" not in table.column_names:
        raise Unreadable(
            Finding("schema", "a column is missing", file=EPISODES, column="episode_index")
        )
    return table, names, files, damaged


def counted(contents: Contents) -> Ints | None:
    """(E,) rows of each episode as meta/episodes has it, in its order; None where it has gaps."""
    table, _, _, damaged = read_episodes(contents)
    if table is None or damaged:
        return None
    lengths = numbers_of(table, "length")
    return lengths.astype(np.int64) if np.isfinite(lengths).all() else None


def numbers_of(table: pa.Table, column: str) -> NDArray[np.float64]:
    """A column of numbers, or of lists of one number; NaN where there is none."""
    if column not in table.column_names:
        return np.full(len(table), np.nan)
    values = [v[0] if isinstance(v, list) and v else v for v in table[column].to_pylist()]
    return np.array([v if isinstance(v, int | float) else np.nan for v in values], np.float64)


def match(table: pa.Table, lengths: Ints) -> Ints:
    """(E,) which row of `table` is each episode's; -1 where none is.

    Raises:
        Unmendable: a row is of no episode that is there, or of which one is not certain.
    """
    named, count = numbers_of(table, "episode_index"), len(lengths)
    length, start = (numbers_of(table, name) for name in ("length", "dataset_from_index"))
    starts = np.cumsum(lengths) - lengths
    if len(table) == count and (whole := _whole(named, length, start, lengths)) is not None:
        return whole
    found = np.full(count, -1)
    rest = []
    for row, name in enumerate(named):
        rows = int(name) if name >= 0 and name < count and name == int(name) else None
        fits = rows is not None and (length[row] == lengths[rows] or start[row] == starts[rows])
        if rows is not None and fits and found[rows] < 0:
            found[rows] = row
        else:
            rest.append(row)
    for row in rest:
        if any(table.slice(row, 1).equals(table.slice(int(same), 1))
               for same in found[found >= 0] if named[same] == named[row]):  # fmt: skip
            continue  # there twice
        fits = np.flatnonzero((found < 0) & (lengths == length[row]) & (starts == start[row]))
        if len(fits) != 1:
            raise Unmendable(
                f"meta/episodes has an episode {named[row]:g} whose rows are not there, or not "
                "certainly its"
            )
        found[fits[0]] = row
    return found


def refuse_lost_rows(contents: Contents, table: pa.Table, rows: Ints, lengths: Ints) -> None:
    """Do not count away what has been lost.

    An episode's rows are taken for whole if anything that counts them agrees: its length, its
    place among all rows, its statistics, its pictures. If all of them count another number, rows
    are lost or there twice, and a new count would hide it.

    Raises:
        Unmendable: so it is with an episode.
    """
    fps = contents.fps
    witnesses = [
        numbers_of(table, "length"),
        numbers_of(table, "dataset_to_index") - numbers_of(table, "dataset_from_index"),
    ]
    columns = table.column_names
    counts = [name for name in columns if name.startswith("stats/") and name.endswith("/count")]
    pictures = set(contents.pictures("video")) | set(contents.pictures("image"))
    counts = [name for name in counts if name.split("/")[1] not in pictures]
    witnesses += [numbers_of(table, name) for name in counts]
    for key in contents.pictures("video"):
        start, end = (numbers_of(table, f"videos/{key}/{n}_timestamp") for n in ("from", "to"))
        witnesses.append(np.rint((end - start) * fps))
    there = rows >= 0
    said = np.stack(witnesses)[:, rows[there]]  # (W, E)
    found = lengths[there]
    lost = np.isfinite(said).any(axis=0) & ~(said == found).any(axis=0)
    if lost.any():
        at = int(lost.argmax())
        expected = int(said[:, at][np.isfinite(said[:, at])][0])
        more = f" (and {lost.sum() - 1} episodes more)" if lost.sum() > 1 else ""
        raise Unmendable(
            f"episode {np.flatnonzero(there)[at]} has {found[at]} rows, and {expected} by all that "
            f"counts them{more}: rows are lost or there twice, and new counts would hide it; "
            "`lfr edit delete` takes an episode out"
        )


def _whole(named: NDArray, length: NDArray, start: NDArray, lengths: Ints) -> Ints | None:
    """Where there are as many rows as episodes: each by its number, or by its place."""
    every, starts = np.arange(len(lengths)), np.cumsum(lengths) - lengths
    if np.array_equal(named, every):
        return every
    by_place = (length == lengths).astype(int) + (start == starts)
    if np.array_equal(np.sort(named), every):
        rows = np.argsort(named)
        by_number = (length[rows] == lengths).astype(int) + (start[rows] == starts)
        if by_number.sum() >= by_place.sum():
            return rows
    return every if (by_place > 0)[named != every].all() else None
