"""``lfr columns``: a LeRobot dataset's columns as the mapping that params.yaml wants of them.

Of a bag, its topics as the mapping that ``lfr import`` wants.
"""

from __future__ import annotations

import argparse
import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa

from lfr.data import tables
from lfr.data.episode import ACTION
from lfr.data.features import dimension_names
from lfr.data.selection import unreadable
from lfr.data.source import Source
from lfr.data.tables import DatasetFiles, conversion
from lfr.errors import DataError
from lfr.importing.bag.files import find_bags, is_bag
from lfr.importing.relations import Relation, relations

DIGITS = 4  # of the bounds
MOST_TASKS = 20  # that are printed
LONGEST_KEY = 40  # characters of a task's name
OBSERVATION = "observation."
MOST_ROWS = 20_000  # that are looked at for what the action does
COPIES = ("copy", "previous")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    about = "folder of a LeRobot dataset, or its name on the Hub (owner/name); or an MCAP bag"
    parser.add_argument("dataset", type=Path, help=about)
    parser.add_argument("--revision", help="of a dataset on the Hub: a branch, tag or commit")
    parser.add_argument("--arm", help="what to call the arm (default: the dataset's robot_type)")
    parser.add_argument("--action", default=ACTION, help=f"column of the action (default {ACTION})")


def run(options: argparse.Namespace) -> None:
    """Print an entry for ``external.arms`` of params.yaml, to be shortened by hand; or of a bag
    the mapping for ``lfr import``."""
    from lfr.data.opening import opened

    if is_bag(options.dataset):
        from lfr.importing.bag.proposal import proposal

        print(proposal(find_bags([options.dataset])), end="")
        return
    with opened(options.dataset, options.revision) as path:
        print(arm_entry(path, options.arm, options.action), end="")


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
    robot = robot if isinstance(robot, str) else None
    rows = files.data([*vectors, "episode_index"])
    low, high = _bounds(files, action, rows)
    found = _relations(rows, vectors, action)
    copies = {column for column in vectors if _is_copy(column, vectors[column], found)}
    name = arm or _slug(robot or files.path.name) or "arm"
    lines = [*_notes(files), f"{name}:", f"  path: {_text(_place(files.source))}"]
    fps = files.fps
    lines.append(f"  fps: {int(fps) if fps == int(fps) else fps}")
    lines += [f"  robot_type: {json.dumps(robot)}"] if robot else []
    lines.append("  observation:")
    taken: list[str] = []
    for column, names in vectors.items():
        if column in copies:
            lines.append(
                f"    # {column} is left out: it repeats the action, and so would a policy"
            )
        elif column.startswith(OBSERVATION):
            lines += [f"    - column: {column}", f"      dims: {_flow(names)}"]
            said = _said(column, names, taken)
            lines += [f"      names: {_flow(said)}"] if said != names else []
            taken += said
    lines += ["  action:", f"    column: {action}", f"    dims: {_flow(vectors[action])}"]
    lines += [f"    low: {json.dumps(low)}", f"    high: {json.dumps(high)}"]
    lines += [f"    # {line}" for line in _commands(found, vectors, action)]
    lines.append("  tasks:")
    instructions = _instructions(files)
    lines += [
        f"    {key}: {{instruction: {json.dumps(words, ensure_ascii=False)}}}"
        for key, words in _keys(instructions[:MOST_TASKS]).items()
    ]
    if len(instructions) > MOST_TASKS:
        lines.append(f"    # and {len(instructions) - MOST_TASKS} more, as meta/tasks.parquet says")
    return "\n".join(lines) + "\n"


def _notes(files: DatasetFiles) -> list[str]:
    """What is to be done before a stage can read the dataset."""
    source, lines = files.source, []
    if name := source.repository:
        lines.append(f"# on the Hub; `hf download {name} --repo-type dataset --revision "
                     f"{source.origin.name} --local-dir {name}` brings it here")  # fmt: skip
    if source.is_older:
        lines.append(f"# LeRobot {source.version}; convert it: {conversion(Path(_place(source)))}")
    return lines


def _place(source: Source) -> str:
    """Where it is, or will be when it has been brought here."""
    return source.repository or Path(source.name).as_posix()


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


def _relations(
    rows: pa.Table, vectors: Mapping[str, tuple[str, ...]], action: str
) -> list[Relation]:
    """Of some of the rows, from the start."""
    some = rows.slice(0, MOST_ROWS)
    wide = {
        column: np.asarray(tables.values(some, column), np.float64).reshape(len(some), -1)
        for column in vectors
    }
    observed = {
        column: values for column, values in wide.items()
        if column.startswith(OBSERVATION) and np.isfinite(values).all()
    }  # fmt: skip
    return relations(wide[action], observed, some["episode_index"].to_numpy())


def _is_copy(column: str, names: tuple[str, ...], found: Sequence[Relation]) -> bool:
    copied = {one.place for one in found if one.column == column and one.kind in COPIES}
    return len(copied) == len(names)


def _commands(
    found: Sequence[Relation], vectors: Mapping[str, tuple[str, ...]], action: str
) -> Iterator[str]:
    """What the action does to what is observed, in lines."""
    names = vectors[action]
    told = [one for one in found if one.kind not in COPIES]
    for one in told:
        seen = f"{vectors[one.column][one.place]} of {one.column}"
        share = f"{100 * one.explained:.0f} % explained"
        if one.kind == "position":
            yield f"{names[one.action]}: a commanded position of {seen} ({share})"
        else:
            size = f"{one.scale:.3g} a step for 1"
            yield f"{names[one.action]}: a change or speed of {seen}, {size} ({share})"
    changes = [names[one.action] for one in told if one.kind == "change"]
    if changes:
        yield f"with `resample` on the arm: deltas: {_flow(tuple(changes))}"


def _bounds(files: DatasetFiles, action: str, rows: pa.Table) -> tuple[list[float], list[float]]:
    """The action's least and greatest values, rounded outwards, never equal."""
    values = tables.values(rows, action)
    if not len(values):
        raise DataError("no rows", file=files.path / "data")
    values = values.reshape(len(values), -1)
    if not (finite := np.isfinite(values)).all():
        row, dimension = np.argwhere(~finite)[0].tolist()
        names = dimension_names(files.features[action], action)
        raise DataError(
            "a value that is not finite, so the action has no bounds", file=files.path / "data",
            episode=rows["episode_index"][row].as_py(),
            column=f"{action}, dimension {names[dimension]}",
            found=float(values[row, dimension]),
        )  # fmt: skip
    bounds = []
    for low, high in zip(values.min(0).tolist(), values.max(0).tolist(), strict=True):
        unit = 10.0 ** (math.floor(math.log10(max(abs(low), abs(high), 1e-6))) - DIGITS + 1)
        least, most = math.floor(low / unit) * unit, math.ceil(high / unit) * unit
        bounds.append((least, most) if least < most else (least - 1.0, most + 1.0))
    low, high = np.array(bounds).T
    return [float(f"{one:.6g}") for one in low], [float(f"{one:.6g}") for one in high]


def _instructions(files: DatasetFiles) -> list[str]:
    listed = files.episodes["tasks"].to_pylist() if "tasks" in files.episodes.column_names else []
    return list(dict.fromkeys(words for tasks in listed for words in tasks or ()))


def _flow(names: tuple[str, ...]) -> str:
    return json.dumps(list(names), ensure_ascii=False)


def _keys(instructions: Sequence[str]) -> dict[str, str]:
    """A name for each task: its words as far as they are letters and digits, and unique."""
    keys: dict[str, str] = {}
    for words in instructions:
        stem = _slug(words)[:LONGEST_KEY].strip("_") or "task"
        if stem[0].isdigit():  # else YAML may take it for a number
            stem = f"task_{stem}"
        key, number = stem, 1
        while key in keys:
            number += 1
            key = f"{stem}_{number}"
        keys[key] = words
    return keys


def _text(value: str) -> str:
    """A string as YAML takes it, quoted where it would be taken for something else."""
    return value if re.fullmatch(r"[\w./][\w./-]*", value, re.ASCII) else json.dumps(value)


def _slug(words: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", words.lower()).strip("_")
