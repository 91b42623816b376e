"""Faults of the files: cut off, absent, left over, changed; and those that mean harm."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from typing import Any

import numpy as np
import pyarrow as pa

from benchmarks.checkers.dataset_copy import EPISODE_ROWS, ROWS, DatasetCopy
from benchmarks.checkers.faults.fault import Fault, K, Plant
from benchmarks.checkers.faults.meta import words

BROKEN = (
    "damag|corrupt|cut|footer|magic|read|parquet|invalid|truncat|decode|moov|empty|load|missing"
    "|open|not found|checksum|crc|page|snappy|decompress"
)
LEFT = "left|orphan|extra|unreferenced|no episode|unknown|names|unused"
SHAPE = "shape|dim|size|schema|memory"
PATH = r"path|outside|escape|traversal|\.\.|out of|format|template|memory|name|placeholder"


def _file(name: str) -> Callable[[DatasetCopy], str]:
    return lambda copy: copy.video if name == "VIDEO" else name


def _bytes(name: str, change: Callable[[bytes], bytes]) -> Plant:
    """Other bytes in a file's place."""

    def plant(copy: DatasetCopy) -> None:
        file = _file(name)(copy)
        changed = change((copy.root / file).read_bytes())
        copy.replace(file, lambda new: new.write_bytes(changed))

    return plant


def _cut(part: float) -> Callable[[bytes], bytes]:
    return lambda data: data[: int(part * len(data))]


def _flipped(data: bytes) -> bytes:
    at = len(data) // 3
    return data[:at] + bytes(b ^ 0xFF for b in data[at : at + 64]) + data[at + 64 :]


def _overwritten(data: bytes) -> bytes:
    """Of the pictures, so that the file's headers stay whole."""
    at = len(data) // 3
    return data[:at] + np.random.default_rng(0).bytes(4096) + data[at + 4096 :]


def _gone(name: str) -> Plant:
    return lambda copy: (copy.root / _file(name)(copy)).unlink()


def _again(name: str) -> Plant:
    """A second file beside it."""

    def plant(copy: DatasetCopy) -> None:
        file = copy.root / _file(name)(copy)
        shutil.copy(file, file.with_stem("file-001"))

    return plant


def _episode_rows(which: Callable[[int], list[int]]) -> Plant:
    def plant(copy: DatasetCopy) -> None:
        copy.episodes = copy.episodes.take(pa.array(which(copy.episodes.num_rows)))

    return plant


def _log(copy: DatasetCopy) -> None:
    """One byte of an episode's log."""
    shutil.rmtree(copy.logs, ignore_errors=True)
    shutil.copytree(copy.clean_logs, copy.logs, copy_function=os.link)
    log = sorted(copy.logs.iterdir())[K]
    data = bytearray(log.read_bytes())
    data[len(data) // 2] ^= 1
    log.unlink()
    log.write_bytes(bytes(data))


def _linked_out(copy: DatasetCopy) -> None:
    file = copy.root / ROWS
    outside = copy.root.parent / f"{copy.root.name}-outside.parquet"
    outside.unlink(missing_ok=True)
    file.rename(outside)
    file.symlink_to(outside)


def _info(**said: Any) -> Plant:
    return lambda copy: copy.info.update(said)


def _shape(shape: list[int]) -> Plant:
    return lambda copy: copy.info["features"]["action"].update(shape=shape)


def _length(length: int | None) -> Plant:
    def plant(copy: DatasetCopy) -> None:
        lengths = copy.of_episodes("length")
        lengths[K] = length
        copy.put_of_episodes("length", lengths)

    return plant


def _listed(copy: DatasetCopy) -> None:
    copy.info["features"] = list(copy.info["features"])


def _no_statistics(copy: DatasetCopy) -> None:
    copy.stats = [1, 2, 3]


def _nobody(copy: DatasetCopy) -> None:
    copy.rows, copy.episodes = copy.rows.slice(0, 0), copy.episodes.slice(0, 0)
    copy.info |= {"total_episodes": 0, "total_frames": 0, "splits": {}}


BOMB = "data/chunk-{chunk_index:03000000000d}/file-{file_index:03d}.parquet"
UP = "../outside/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"

FAULTS = {
    "data_parquet_truncated": Fault("files", _bytes(ROWS, _cut(0.7)), BROKEN),
    "data_parquet_empty": Fault("files", _bytes(ROWS, _cut(0)), BROKEN),
    "episodes_parquet_truncated": Fault("files", _bytes(EPISODE_ROWS, _cut(0.7)), BROKEN),
    "video_truncated": Fault("files", _bytes("VIDEO", _cut(0.7)), f"{BROKEN}|video"),
    "video_empty": Fault("files", _bytes("VIDEO", _cut(0)), f"{BROKEN}|video"),
    "video_absent": Fault("files", _gone("VIDEO"), f"{BROKEN}|video"),
    "data_absent": Fault("files", _gone(ROWS), f"{BROKEN}|data"),
    "data_parquet_bits_flipped": Fault("files", _bytes(ROWS, _flipped), BROKEN),
    "video_bits_flipped": Fault("files", _bytes("VIDEO", _overwritten), f"{BROKEN}|video|frame"),
    "left_over_data_file": Fault("files", _again(ROWS), LEFT),
    "left_over_video_file": Fault("files", _again("VIDEO"), LEFT),
    "episode_row_missing": Fault(
        "files", _episode_rows(lambda n: [e for e in range(n) if e != K]),
        "episode|missing|count|row|metadata",
    ),
    "episode_row_twice": Fault(
        "files", _episode_rows(lambda n: sorted([*range(n), K])),
        "episode|twice|dup|count|index|order",
    ),
    "log_changed": Fault("log", _log, "log|hash|sha"),
    "symlink_out": Fault("hostile", _linked_out, "link|outside|escape|leads out"),
    "dotdot_in_data_path": Fault("hostile", _info(data_path=UP), PATH),
    "format_width_bomb": Fault("hostile", _info(data_path=BOMB), PATH),
    "huge_shape": Fault("hostile", _shape([2_000_000_000]), SHAPE),
    "negative_shape": Fault("hostile", _shape([-7]), SHAPE),
    "huge_total_episodes": Fault(
        "hostile", _info(total_episodes=10**12, total_frames=10**15),
        "total|count|episodes|frames",
    ),
    "negative_length": Fault("hostile", _length(-5), "length|count|negative|row|frames"),
    "null_in_episode_length": Fault("hostile", _length(None), "episode|null|missing|gap"),
    "huge_episode_index": Fault(
        "hostile", lambda copy: copy.change("episode_index", copy.span(K), 2**62),
        "index|episode|count|range",
    ),
    "escape_codes_in_task": Fault(
        "hostile", words("\x1b[2J\x1b[31mlift the cube\x07", everywhere=True),
        "task|control|escape|word|not print",
    ),
    "features_is_a_list": Fault("hostile", _listed, "feature|schema|info|type"),
    "stats_is_a_list": Fault("hostile", _no_statistics, "stat|json|type"),
    "no_episodes": Fault("hostile", _nobody, "episode|row|empty|no "),
}  # fmt: skip
