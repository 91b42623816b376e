"""LeRobot v2.1 and v2.0, which keep a file for each episode, with their metadata as v3.0 has it.

| v2.1 | v3.0 |
|---|---|
| meta/episodes.jsonl, meta/episodes_stats.jsonl | meta/episodes |
| meta/tasks.jsonl | meta/tasks.parquet |
| meta/stats.json, of v2.0 alone | meta/stats.json |
| data/chunk-000/episode_000000.parquet | the same file, by another format string |
| videos/chunk-000/KEY/episode_000000.mp4 | the same |

Rows and pictures stay where they are. What a line lacks is lacking in the table, and a line that
cannot be read is told as a `Fault`.
"""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from lfr.artifacts import parse_json, write_json
from lfr.data.source import VERSION, Fault
from lfr.data.templates import renamed

V21, V20 = "v2.1", "v2.0"
INFO, EPISODES, TASKS = "meta/info.json", "meta/episodes.jsonl", "meta/tasks.jsonl"
EPISODES_STATS, STATS = "meta/episodes_stats.jsonl", "meta/stats.json"
STATISTICS = ("min", "max", "mean", "std", "count")
CHUNK = 1000  # episodes in a folder, where info.json does not say

Row = dict[str, Any]


def older_version(path: Path, info: Any) -> str | None:
    """The version of the dataset in a folder; None if it is not v2.1 or v2.0.

    Args:
        info: what its info.json holds, which need not be right.
    """
    if not isinstance(info, dict):
        return None
    said = info.get("codebase_version")
    has_lines, has_table = (path / EPISODES).is_file(), (path / "meta" / "episodes").is_dir()
    if said in (V21, V20):
        return said if has_lines or not has_table else None
    if not has_lines or has_table:
        return None
    return V20 if (path / STATS).is_file() and not (path / EPISODES_STATS).is_file() else V21


def write_as_v30(path: Path, to: Path, info: Row, version: str, *, stats: bool) -> list[Fault]:
    """Write the metadata of the dataset at `path` into `to`/meta, in v3.0's form.

    Args:
        path: the dataset's folder.
        to: an empty folder.
        info: what its info.json holds.
        version: as `older_version` tells it.
        stats: with the statistics of each episode.
    """
    faults: list[Fault] = []
    if (said := info.get("codebase_version")) != version:
        faults.append(Fault("info", "files of another version than info.json says", INFO, said,
                            version, fatal=False))  # fmt: skip
    size = info.get("chunks_size")
    if not isinstance(size, int) or isinstance(size, bool) or size < 1:
        size = CHUNK
    new = {**info, "codebase_version": VERSION}
    for template in ("data_path", "video_path"):
        if info.get(template) is not None:
            new[template] = _template(template, info[template], faults)
    write_json(to / INFO, new, allow_nan=True)
    tasks = _tasks(path, faults)
    if tasks is not None:
        pq.write_table(tasks, to / "meta" / "tasks.parquet")
    if version == V20 and (path / STATS).is_file():
        shutil.copyfile(path / STATS, to / STATS)
    if not (path / EPISODES).is_file():
        return [*faults, Fault("missing-file", "no table of episodes", EPISODES)]
    table = _episodes(path, new, size, faults)
    if stats and version == V21:
        table = _with_statistics(path, table, faults)
    file = to / "meta" / "episodes" / "chunk-000" / "file-000.parquet"
    file.parent.mkdir(parents=True)
    pq.write_table(table, file)
    return _gathered(faults)


def _gathered(faults: Sequence[Fault]) -> list[Fault]:
    """The first of each kind in each file, and how many there are."""
    count = Counter((fault.message, fault.file) for fault in faults)
    first = {(fault.message, fault.file): fault for fault in reversed(faults)}
    return [replace(first[kind], places=places) for kind, places in count.items()]


def _template(name: str, template: object, faults: list[Fault]) -> object:
    """One for each episode has the episode's number, where v3.0 has the file's."""
    kept = ("video_key", "chunk_index", "file_index")
    fields = {"episode_chunk": "chunk_index", "episode_index": "file_index"}
    try:
        return renamed(template, {**fields, **dict(zip(kept, kept, strict=True))})
    except ValueError as error:
        faults.append(Fault("info", "no such path", INFO, f"{name}: {error}"))
        return template


def _tasks(path: Path, faults: list[Fault]) -> pa.Table | None:
    if not (path / TASKS).is_file():
        return None
    rows = [
        (number, row["task"])
        for line, row in _lines(path, TASKS, faults)
        if (number := _whole(row.get("task_index"), TASKS, line, "task_index", faults)) is not None
        and isinstance(row.get("task"), str)
    ]
    numbers, words = zip(*rows, strict=True) if rows else ((), ())
    return pa.table({"task_index": pa.array(numbers, pa.int64()),
                     "task": pa.array(words, pa.string())})  # fmt: skip


def _episodes(path: Path, info: Row, size: int, faults: list[Fault]) -> pa.Table:
    """meta/episodes, in the order of the episodes' numbers."""
    rows: list[tuple[int, int, Row]] = []
    for line, row in _lines(path, EPISODES, faults):
        found = [_whole(row.get(n), EPISODES, line, n, faults) for n in ("episode_index", "length")]
        if found[0] is not None and found[1] is not None:
            rows.append((found[0], found[1], row))
    rows.sort(key=lambda each: each[0])
    number = np.array([each[0] for each in rows], np.int64)
    length = np.array([each[1] for each in rows], np.int64)
    ends, zeros = np.cumsum(length), np.zeros(len(rows), np.int64)
    columns: dict[str, Any] = {
        "episode_index": number,
        "tasks": pa.array([_words(each[2].get("tasks")) for each in rows], pa.list_(pa.string())),
        "length": length,
        "data/chunk_index": number // size,
        "data/file_index": number,
        "dataset_from_index": ends - length,
        "dataset_to_index": ends,
        "meta/episodes/chunk_index": zeros,
        "meta/episodes/file_index": zeros,
    }
    features, fps = info.get("features"), info.get("fps")
    rate = float(fps) if isinstance(fps, int | float) and 0 < fps < 1e9 else 1.0
    for key, feature in features.items() if isinstance(features, dict) else ():
        if isinstance(feature, dict) and feature.get("dtype") == "video":
            columns |= {
                f"videos/{key}/chunk_index": number // size,
                f"videos/{key}/file_index": number,
                f"videos/{key}/from_timestamp": zeros.astype(np.float64),
                f"videos/{key}/to_timestamp": length / rate,
            }
    for key in dict.fromkeys(key for *_, row in rows for key in row):
        if key not in columns and "/" not in key:
            try:  # whatever else a recorder wrote of its episodes
                columns[key] = pa.array([row.get(key) for *_, row in rows])
            except (pa.ArrowException, OverflowError, TypeError, ValueError):
                continue  # of different types: no reader of v3.0 would know what to do with it
    return pa.table(columns)


def _with_statistics(path: Path, table: pa.Table, faults: list[Fault]) -> pa.Table:
    """The table with a column for each statistic of each feature, null where a line has it not."""
    if not (path / EPISODES_STATS).is_file():
        return table
    place = {number: row for row, number in enumerate(table["episode_index"].to_pylist())}
    found: dict[str, list[Any]] = {}
    there: set[int] = set()
    for line, row in _lines(path, EPISODES_STATS, faults):
        number = _whole(row.get("episode_index"), EPISODES_STATS, line, "episode_index", faults)
        if number is None:
            continue
        if number not in place:
            faults.append(Fault("statistics", "of an episode that is not there", EPISODES_STATS,
                                f"episode {number} in line {line}"))  # fmt: skip
            continue
        there.add(number)
        for key, values in _numbers(row.get("stats")):
            found.setdefault(key, [None] * len(table))[place[number]] = values
    if lacking := sorted(set(place) - there):
        faults.append(Fault("statistics", "episodes without statistics", EPISODES_STATS,
                            f"none of episode {lacking[0]}", f"{len(place)} episodes"))  # fmt: skip
    for key, values in found.items():
        try:
            table = table.append_column(f"stats/{key}", pa.array(values))
        except pa.ArrowException as error:
            faults.append(Fault("statistics", "numbers in different forms", EPISODES_STATS,
                                f"{key}: {error}"))  # fmt: skip
    return table


def _numbers(stats: Any) -> Iterator[tuple[str, list[Any]]]:
    """`<feature>/<statistic>` and its numbers, as nested as they are; what is no number is not."""
    for key, named in stats.items() if isinstance(stats, dict) else ():
        for name in STATISTICS:
            if not isinstance(named, dict) or name not in named:
                continue
            try:
                array = np.atleast_1d(np.asarray(named[name], np.float64))
            except (TypeError, ValueError, OverflowError):
                continue
            yield f"{key}/{name}", array.tolist()


def _lines(path: Path, file: str, faults: list[Fault]) -> Iterator[tuple[int, Row]]:
    """The objects of a file of one in each line, and their lines' numbers, which begin at 1."""
    with (path / file).open("rb") as stream:
        for number, line in enumerate(stream, 1):
            if not line.strip():
                continue
            try:
                row = parse_json(line.decode("utf-8"))
                if not isinstance(row, dict):
                    raise ValueError(f"{type(row).__name__}, no object")
            except ValueError as error:
                faults.append(Fault("damaged-file", "a line that is cut off or no JSON", file,
                                    f"line {number}: {error}"))  # fmt: skip
            else:
                yield number, row


def _whole(value: Any, file: str, line: int, key: str, faults: list[Fault]) -> int | None:
    """A whole number of an index or of rows; None, and a fault, where there is none."""
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**53:
        return value
    faults.append(Fault("schema", "a line without a whole number", file,
                        f"{key}: {value!r:.40} in line {line}"))  # fmt: skip
    return None


def _words(tasks: Any) -> Sequence[str] | None:
    if not isinstance(tasks, list) or not all(isinstance(task, str) for task in tasks):
        return None
    return tasks
