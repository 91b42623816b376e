"""meta/episodes: a row for each episode, with as many rows and where they are."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import PurePosixPath
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from lfr.curation.checks.counts import task_words
from lfr.curation.checks.statistics import stored_stats
from lfr.curation.contents import EPISODES, Contents, with_column
from lfr.curation.finding import Unreadable
from lfr.curation.repair.draft import Draft, Unmendable
from lfr.curation.repair.episode_rows import match, numbers_of, read_episodes, refuse_lost_rows
from lfr.curation.repair.rows import episode_lengths
from lfr.curation.repair.video_places import video_places

FIRST_FILE = f"{EPISODES}/chunk-000/file-000.parquet"


def mend_episodes(draft: Draft) -> None:
    """Give every episode its row, and count and place it by the rows and the videos.

    Raises:
        Unmendable: the rows or the episodes are not certain.
    """
    contents = draft.contents()
    lengths = episode_lengths(contents)
    found, names, files, damaged = read_episodes(contents)
    if found is None:
        found = pa.table({"episode_index": pa.array([], pa.int64())})
        rows = np.full(len(lengths), -1)
    else:
        rows = match(found, lengths)
        refuse_lost_rows(contents, found, rows, lengths)
    table = found.take(pa.array([None if row < 0 else row for row in rows.tolist()], pa.int64()))
    names, placed = _files(names, files, damaged, rows)
    said: dict[str, int] = {}
    if lost := int((rows < 0).sum()):
        _refuse_lost_episodes(contents, int(lengths.sum()))
        said["rows of meta/episodes made anew"] = lost
        _say_what_is_lost(draft, found, rows)
    if (gone := len(found) - len(set(rows[rows >= 0].tolist()))) > 0:
        said["rows that were there twice taken out"] = gone
    if (np.diff(rows[rows >= 0]) < 0).any():
        said["put in the order of the episodes"] = len(rows)
    columns = _tasks(contents, table)
    columns |= _places(contents, lengths)
    for key in contents.pictures("video"):
        try:
            columns |= video_places(contents, table, lengths, key)
        except Unmendable as reason:
            draft.not_mended(reason)
    numbers = [_numbers(name) for name in names]
    for i, name in enumerate(("chunk_index", "file_index")):
        column = f"meta/episodes/{name}"
        if all(numbers) and (column in table.column_names or not len(found)):
            columns[column] = np.array([n[i] for n in numbers if n])[placed]
    for name, values in columns.items():
        wrong = _differ(table, name, values)
        if wrong.any():
            table = put_column(table, name, values)
            known = int((wrong & (rows >= 0)).sum())
            if known:
                said[name] = known
    _write(draft, contents, table, names, placed, found, files, said)


def put_column(table: pa.Table, name: str, values: Any) -> pa.Table:
    """`with_column`, in a new type where the old one cannot hold the values."""
    try:
        return with_column(table, name, values)
    except (pa.ArrowException, ValueError):
        return with_column(table.drop_columns([name]), name, values)


def _files(
    names: list[str], files: NDArray, damaged: list[str], rows: NDArray
) -> tuple[list[str], NDArray]:
    """Names of the files there will be, and (E,) which of them each episode's row is in.

    A row stays in its file. One made anew comes to the file before it, or to a damaged one that
    lies between that of the row before and that of the row after.
    """
    every = sorted({*names, *damaged}) or [FIRST_FILE]
    known = np.array([every.index(name) for name in names], np.int64)
    placed = np.where(rows >= 0, known[files][rows] if len(files) else -1, -1)
    spare = [every.index(name) for name in damaged] or ([0] if not names else [])
    before = -1
    for episode in np.flatnonzero(placed < 0):
        before = int(placed[:episode].max(initial=-1))
        after = placed[episode:][placed[episode:] >= 0]
        between = [i for i in spare if i >= before and (not len(after) or i <= after.min())]
        if between:
            placed[episode] = between[0]
        else:
            placed[episode] = before if before >= 0 else after.min(initial=len(every) - 1)
    return every, np.sort(placed)


def _refuse_lost_episodes(contents: Contents, count: int) -> None:
    """Do not write meta/episodes without episodes whose rows are lost with theirs."""
    said = [contents.info.get("total_frames")]
    with suppress(Unreadable):
        stats = [each for each in stored_stats(contents).values() if isinstance(each, dict)]
        said += [c[0] for each in stats if isinstance(c := each.get("count"), list) and c]
    said = [number for number in said if isinstance(number, int)]
    if said and count not in said:
        raise Unmendable(
            f"meta/episodes: {count} rows are there, and {said[0]} by all that counts them: "
            "episodes are lost, and new ones would hide it"
        )


def _say_what_is_lost(draft: Draft, found: pa.Table, rows: NDArray) -> None:
    kept = ("episode_index", "tasks", "length", "dataset_", "data/", "videos/", "meta/", "stats/")
    others = [name for name in found.column_names if not name.startswith(kept)]
    others += ["statistics of pictures"] if draft.contents().pictures() else []
    others += [] if len(found) else ["columns of the dataset's own, if it had some"]
    if others:
        episodes = ", ".join(map(str, np.flatnonzero(rows < 0)[:5]))
        draft.not_mended(
            f"of the episodes whose rows of meta/episodes were lost ({episodes}"
            f"{', ...' if (rows < 0).sum() > 5 else ''}) these are not known, so empty: "
            f"{', '.join(others)}"
        )


def _tasks(contents: Contents, table: pa.Table) -> dict[str, Any]:
    """The lists of tasks, where an episode has none."""
    lists = table["tasks"].to_pylist() if "tasks" in table.column_names else [None] * len(table)
    every = {"episode_index": np.arange(len(table))}
    if all(isinstance(one, list) for one in lists):
        return every
    try:
        words = task_words(contents)
        index = contents.column("task_index").ravel()
        episode = contents.column("episode_index").ravel()
    except Unreadable:
        return every  # said where the tasks are checked
    pairs = np.unique(np.stack([episode, index], axis=1), axis=0)
    done: list[list[str]] = [[] for _ in lists]
    for number, task in pairs.tolist():
        if task not in words:
            return every
        done[number].append(words[task])
    lists = [old if isinstance(old, list) else new for old, new in zip(lists, done, strict=True)]
    return {**every, "tasks": pa.array(lists, pa.list_(pa.string()))}


def _places(contents: Contents, lengths: NDArray) -> dict[str, Any]:
    """Where each episode's rows are."""
    ends = np.cumsum(lengths)
    columns: dict[str, Any] = {"length": lengths}
    limits = np.cumsum(contents.rows_of_files)
    first = np.searchsorted(limits, ends - lengths, side="right")
    last = np.searchsorted(limits, ends - 1, side="right")
    files = [contents.relative(file) for file in contents.data_files]
    numbers = [_numbers(name) for name in files]
    named = all(
        n and contents.named("data_path", chunk_index=n[0], file_index=n[1]) == name
        for n, name in zip(numbers, files, strict=True)
    )
    if named and (first == last).all():
        known = np.array(numbers)
        columns |= {"data/chunk_index": known[first, 0], "data/file_index": known[first, 1]}
    return {**columns, "dataset_from_index": ends - lengths, "dataset_to_index": ends}


def _numbers(name: str) -> tuple[int, int] | None:
    """chunk_index and file_index of a file's name, as LeRobot names files."""
    path = PurePosixPath(name)
    found = re.fullmatch(r"chunk-(\d+)/file-(\d+)", f"{path.parent.name}/{path.stem}")
    return (int(found[1]), int(found[2])) if found else None


def _differ(table: pa.Table, name: str, values: Any) -> NDArray[np.bool_]:
    """(E,) where a column of the table is another than these values."""
    if name not in table.column_names:
        return np.ones(len(table), bool)
    if isinstance(values, pa.Array):
        pairs = zip(table[name].to_pylist(), values.to_pylist(), strict=True)
        return np.array([old != new for old, new in pairs], bool)
    return ~(numbers_of(table, name) == values)


def _write(
    draft: Draft, contents: Contents, table: pa.Table, names: list[str], placed: NDArray,
    found: pa.Table, files: NDArray, said: dict[str, int],
) -> None:  # fmt: skip
    """Write the files that change, and say what does once for all of them."""
    changed = []
    for i, name in enumerate(names):
        part = table.filter(pa.array(placed == i))
        path = contents.path / name
        try:
            same = path.is_file() and contents.rows_of(path).equals(part)
        except Unreadable:
            same = False
        if same:
            continue
        changed.append(name)
        with draft.replaced(name) as new:
            pq.write_table(part, new, compression="snappy")
    if not changed:
        return
    if not said:
        said["a damaged file without episodes emptied, or columns as in the other files"] = 1
    file = changed[0] if len(changed) == 1 else EPISODES
    for what, places in said.items():
        draft.mended(file, what, places)
