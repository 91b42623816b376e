"""``lfr columns``: a LeRobot dataset's columns as the mapping that params.yaml wants of them."""

from __future__ import annotations

import argparse
import json
import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lfr.data import tables
from lfr.data.episode import ACTION
from lfr.data.selection import dimension_names, unreadable
from lfr.data.tables import DatasetFiles
from lfr.errors import DataError

DIGITS = 4  # of the bounds
OBSERVATION = "observation."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("dataset", type=Path, help="folder of a LeRobot v3.0 dataset")
    parser.add_argument("--arm", help="what to call the arm (default: the dataset's robot_type)")
    parser.add_argument("--action", default=ACTION, help=f"column of the action (default {ACTION})")


def run(options: argparse.Namespace) -> None:
    """Print an entry for ``external.arms`` of params.yaml, to be shortened by hand."""
    print(arm_entry(options.dataset, options.arm, options.action), end="")


def arm_entry(path: Path, arm: str | None = None, action: str = ACTION) -> str:
    """The entry as YAML: every vector of numbers is observed, the bounds are the data's.

    A dimension whose name does not say what it is gets one that says so (`lfr.spaces`).

    Raises:
        DataError: there is no LeRobot v3.0 dataset, or it has no vector called ``action``.
    """
    files = DatasetFiles.open(path)
    vectors = {
        key: dimension_names(feature, key)
        for key, feature in files.features.items()
        if feature["dtype"] in ("float32", "float64") and len(feature["shape"]) == 1
    }
    if action not in vectors:
        raise DataError(
            "no such vector of numbers", file=files.path / "meta" / "info.json", column=action,
            found=", ".join(vectors), expected=action,
        )  # fmt: skip
    robot = files.info.get("robot_type")
    low, high = _bounds(files, action)
    lines = [f"{arm or _slug(robot or files.path.name)}:", f"  path: {path.as_posix()}"]
    lines.append(f"  fps: {files.info['fps']}")
    lines += [f"  robot_type: {json.dumps(robot)}"] if robot else []
    lines.append("  observation:")
    taken: list[str] = []
    for column, names in vectors.items():
        if column.startswith(OBSERVATION):
            lines += [f"    - column: {column}", f"      dims: {_flow(names)}"]
            said = _said(column, names, taken)
            lines += [f"      names: {_flow(said)}"] if said != names else []
            taken += said
    lines += ["  action:", f"    column: {action}", f"    dims: {_flow(vectors[action])}"]
    lines += [f"    low: {json.dumps(low)}", f"    high: {json.dumps(high)}", "  tasks:"]
    lines += [
        f"    {_slug(words)}: {{instruction: {json.dumps(words, ensure_ascii=False)}}}"
        for words in _instructions(files)
    ]
    return "\n".join(lines) + "\n"


def _said(column: str, names: tuple[str, ...], taken: Sequence[str]) -> tuple[str, ...]:
    """The names as they can be read: joints and numbers, where they do not say what they are."""
    nothing = {*unreadable(names), *taken}
    given = []
    for name in names:
        kind = "joint" if "joint" in f"{column}{name}".lower() else "number"
        said = name if name not in nothing else f"{kind}.{name.removeprefix(OBSERVATION)}"
        if said in taken:
            said = f"{kind}.{column.removeprefix(OBSERVATION)}.{name}"
        given.append(said)
    return tuple(given)


def _bounds(files: DatasetFiles, action: str) -> tuple[list[float], list[float]]:
    """The action's least and greatest values, rounded outwards, never equal."""
    values = tables.values(files.data([action]), action)
    values = values.reshape(len(values), -1)
    bounds = []
    for low, high in zip(values.min(0).tolist(), values.max(0).tolist(), strict=True):
        unit = 10.0 ** (math.floor(math.log10(max(abs(low), abs(high), 1e-6))) - DIGITS + 1)
        least, most = math.floor(low / unit) * unit, math.ceil(high / unit) * unit
        bounds.append((least, most) if least < most else (least - 1.0, most + 1.0))
    low, high = np.array(bounds).T
    return [float(f"{one:.6g}") for one in low], [float(f"{one:.6g}") for one in high]


def _instructions(files: DatasetFiles) -> list[str]:
    listed = files.episodes["tasks"].to_pylist() if "tasks" in files.episodes.column_names else []
    return list(dict.fromkeys(words for tasks in listed for words in tasks))


def _flow(names: tuple[str, ...]) -> str:
    return json.dumps(list(names), ensure_ascii=False)


def _slug(words: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", words.lower()).strip("_")
