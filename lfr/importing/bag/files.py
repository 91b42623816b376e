"""Bags as they lie on the disk: an MCAP file, or the folder of several that `ros2 bag` wrote."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.errors import DataError
from lfr.params import read_yaml

METADATA = "metadata.yaml"
MCAP = ".mcap"
CONVERT = "`ros2 bag convert` makes it MCAP"
OTHER = {
    ".db3": f"a bag in SQLite; {CONVERT}",
    ".bag": "a bag of ROS 1; `rosbags-convert` makes it a ROS 2 bag in MCAP",
    ".zstd": "a compressed file; `zstd -d` makes it MCAP",
}


@dataclass(frozen=True)
class Bag:
    """One recording.

    Attributes:
        path: as it was named, a file or a folder.
        files: its MCAP files, in the order of time.
    """

    path: Path
    files: tuple[Path, ...]

    def __str__(self) -> str:
        return str(self.path)


def is_bag(path: Path) -> bool:
    """Whether a path is a bag or a folder of bags, by its names alone."""
    if path.is_dir():
        return (path / METADATA).is_file() or any(map(_looks_like_bag, path.iterdir()))
    return path.suffix in (MCAP, *OTHER)


def find_bags(paths: Sequence[Path]) -> list[Bag]:
    """The bags of files and folders, in this order, those of a folder by name and number.

    What belongs to one bag is said by the `metadata.yaml` of its folder; in a folder without it
    every MCAP file and every folder with a `metadata.yaml` is a bag of its own.

    Raises:
        DataError: there is no such file, no bag in a folder, a bag in another format than MCAP, or
            one that is given twice.
    """
    bags = [bag for path in paths for bag in _bags(Path(path))]
    seen: dict[Path, Path] = {}
    for bag in bags:
        for file in bag.files:
            if (real := file.resolve()) in seen:
                raise DataError("given twice", file=file, found=f"also as {seen[real]}")
            seen[real] = bag.path
    return bags


def _bags(path: Path) -> list[Bag]:
    if not path.exists():
        raise DataError("no such bag", file=path)
    if path.is_file():
        _check_format(path)
        return [Bag(path, (path,))]
    if (path / METADATA).is_file():
        return [Bag(path, _listed(path))]
    inside = sorted(filter(_looks_like_bag, path.iterdir()), key=_by_number)
    if not inside:
        raise DataError("no bag in this folder", file=path, expected=f"{METADATA}, or *{MCAP}")
    return [bag for each in inside for bag in _bags(each)]


def _looks_like_bag(path: Path) -> bool:
    return path.suffix == MCAP or path.suffix in OTHER or (path / METADATA).is_file()


def _listed(folder: Path) -> tuple[Path, ...]:
    """The files that `metadata.yaml` lists; only their names count, as old ones have folders."""
    file = folder / METADATA
    about: Any = read_yaml(file).get("rosbag2_bagfile_information")
    listed = about.get("relative_file_paths") if isinstance(about, dict) else None
    if not isinstance(listed, list) or not listed or not all(isinstance(p, str) for p in listed):
        raise DataError("not what ros2 bag writes", file=file,
                        column="rosbag2_bagfile_information.relative_file_paths",
                        found=listed, expected="a list of files")  # fmt: skip
    if str(about.get("compression_mode") or "").upper() == "MESSAGE":
        raise DataError(f"messages compressed one by one; {CONVERT}", file=file)
    files = tuple(folder / Path(name).name for name in listed)
    for each in files:
        _check_format(each)
        if not each.is_file():
            raise DataError("a file of the bag is missing", file=each,
                            expected=f"{len(files)} files, as {METADATA} lists")  # fmt: skip
    return files


def _check_format(path: Path) -> None:
    if path.suffix != MCAP:
        wrong = OTHER.get(path.suffix, "not a bag")
        raise DataError(wrong, file=path, expected=f"*{MCAP}, or a folder of ros2 bag")


def _by_number(path: Path) -> list[tuple[int, str]]:
    """`take_10` after `take_9`."""
    return [(int(part), "") if part.isdecimal() else (-1, part)
            for part in re.split(r"(\d+)", path.name)]  # fmt: skip
