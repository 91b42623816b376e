"""All episodes of a dataset or of a folder of logs, as a table in the terminal.

A dataset's is read from a few columns of its Parquet files, so that ten thousand episodes are
listed in about a second; of a log the metadata and the rewards are read.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.data import tables
from lfr.data.episode import FPS, REWARD, SUCCESS
from lfr.data.tables import DatasetFiles
from lfr.errors import DataError
from lfr.view.selection import Entry

EPISODE = "episode_index"
NUMBERS = ("episode", "frames", "seconds", "success", "reward", "seed", "score")
WORDS = ("kinds", "note")


def dataset_entries(path: Path) -> list[Entry]:
    """Every episode of the LeRobot v3.0 dataset at `path`, in order.

    Raises:
        DataError: no such dataset, a file that is cut off, or another format.
    """
    files = DatasetFiles.open(path)
    rows = files.episodes
    numbers = rows[EPISODE].to_numpy()
    lengths = rows["length"].to_pylist()
    known = {name: _column(rows, name, kind) for name, kind in (("success", bool), ("seed", int))}
    rewards, successes, there = _per_episode(files, numbers)
    entries = [
        Entry(
            index=int(number),
            length=lengths[row],
            success=successes[row] if known["success"][row] is None else known["success"][row],
            reward=rewards[row],
            seed=known["seed"][row],
            note="" if there[row] else "its rows are not there",
        )
        for row, number in enumerate(numbers)
    ]
    return sorted(entries, key=lambda entry: entry.index)


def log_entries(logs: Sequence[Path]) -> list[Entry]:
    """Every log of a folder, in order; one that cannot be read says so in its note."""
    return [_log_entry(index, path) for index, path in enumerate(logs)]


def table(entries: Sequence[Entry], of: int | None = None, fps: float = FPS) -> str:
    """The entries as lines of text, with their sum below.

    Args:
        entries: to show.
        of: how many there are in all, where these are a selection.
        fps: frames per second.
    """
    rows = [
        {
            "episode": str(entry.index),
            "frames": str(entry.length),
            "seconds": f"{entry.length / fps:.2f}",
            "success": {True: "yes", False: "no", None: "-"}[entry.success],
            "reward": "-" if entry.reward is None else f"{entry.reward:.3f}",
            "seed": "-" if entry.seed is None else str(entry.seed),
            "score": "" if entry.score is None else f"{entry.score:g}",
            "kinds": ", ".join(entry.kinds),
            "note": entry.note,
        }
        for entry in entries
    ]
    optional = ("score", *WORDS)  # what nothing is known of has no column
    shown = [n for n in (*NUMBERS, *WORDS) if n not in optional or any(row[n] for row in rows)]
    rows.insert(0, {name: name for name in shown})
    widths = {name: max(len(row[name]) for row in rows) for name in shown}
    lines = [
        "  ".join(
            row[name].rjust(widths[name]) if name in NUMBERS else row[name].ljust(widths[name])
            for name in shown
        ).rstrip()
        for row in rows
    ]
    return "\n".join([*lines, summary(entries, of, fps)])


def summary(entries: Sequence[Entry], of: int | None = None, fps: float = FPS) -> str:
    """One line: how many episodes, successes, frames and seconds."""
    frames = sum(entry.length for entry in entries)
    said = [entry.success for entry in entries if entry.success is not None]
    parts = [f"{len(entries)}" + (f" of {of}" if of not in (None, len(entries)) else "")]
    parts[0] += " episode" if parts[0] == "1" else " episodes"
    if said:
        parts.append(f"{sum(said)} succeeded")
    return ", ".join([*parts, f"{frames} frames", f"{frames / fps:.0f} s"])


def _column(rows: Any, name: str, kind: type) -> list[Any]:
    """A column of meta/episodes, None where there is none or it holds something else."""
    if name not in rows.column_names:
        return [None] * len(rows)
    return [value if isinstance(value, kind) else None for value in rows[name].to_pylist()]


def _per_episode(
    files: DatasetFiles, numbers: NDArray[np.int64]
) -> tuple[list[float | None], list[bool | None], list[bool]]:
    """Summed reward and success of the episodes of these numbers, from the frames themselves, and
    whether there are any; nothing is known of an episode of which there are none.
    """
    columns = [key for key in (REWARD, SUCCESS) if key in files.features]
    count = len(numbers)
    rewards: list[float | None] = [None] * count
    successes: list[bool | None] = [None] * count
    if not columns or not count:
        return rewards, successes, [True] * count
    rows = files.data([EPISODE, *columns])
    owner = tables.values(rows, EPISODE)
    place = np.full(int(max(numbers.max(), owner.max())) + 1, count)
    place[numbers] = np.arange(count)
    there = [bool(rows) for rows in np.bincount(place[owner], minlength=count + 1)[:count]]

    def summed(key: str) -> list[float | None]:
        flat = np.asarray(tables.values(rows, key), np.float64).reshape(len(owner), -1)[:, 0]
        sums = np.bincount(place[owner], flat, count + 1)[:count].tolist()
        return [total if is_there else None for total, is_there in zip(sums, there, strict=True)]

    if REWARD in columns:
        rewards = summed(REWARD)
    if SUCCESS in columns:
        successes = [None if total is None else bool(total) for total in summed(SUCCESS)]
    return rewards, successes, there


def _log_entry(index: int, path: Path) -> Entry:
    from google.protobuf.message import DecodeError

    from lfr.artifacts import parse_json
    from lfr.data import messages
    from lfr.data.mcap_file import open_whole

    try:
        with open_whole(path) as reader:
            said = {record.name: record.metadata for record in reader.iter_metadata()}
            ours = {"episode", "outcome"} <= said.keys()  # else these rewards are anybody's
            topics = [messages.REWARD] if ours else []
            rewards = [(schema, message) for schema, _, message in reader.iter_messages(topics)]
        outcome = {key: parse_json(text) for key, text in said["outcome"].items()}
        seed = parse_json(said["episode"]["seed"])
        frames, success = outcome["frames"], outcome["success"]
        if [type(one) for one in (seed, frames, success)] != [int, int, bool]:
            raise ValueError("numbers of another type")
        total = 0.0
        for schema, message in rewards:
            if schema is not None:
                reward: Any = messages.message_class(schema.name, schema.data)
                total += reward.FromString(message.data).reward
        return Entry(index, frames, success, total, seed, path.name)
    except DataError as error:
        return Entry(index, 0, note=f"{path.name}: {error.message}")
    except (KeyError, ValueError, TypeError, AttributeError, DecodeError):
        return Entry(index, 0, note=f"{path.name}: no log of lfr")
