"""The table of all runs, and their curves: what tables and figures are computed from."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import asdict, astuple, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lfr.artifacts import write_whole
from lfr.errors import DataError

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

RESULTS = Path("results/evidence")
RUNS, CURVES = RESULTS / "runs.csv", RESULTS / "curves.csv"


@dataclass(frozen=True)
class Run:
    """A policy and how it did.

    Attributes:
        transfer: name of the transfer.
        task: the new task.
        source, source_controller, target, target_controller: the two embodiments.
        method: a link of the chain (`lfr.evaluation.chain`) or a method that learns; G's own is
            ``lfr``.
        option: of the mapping, where one is used (`evidence.yaml`).
        reward: that it has learned from; empty before learning.
        demonstrations: of each arm and task.
        seed: of the repetition.
        env_steps: of learning on the target; 0 before.
        starts, successes: held-out starts, and how many ended in success.
        judge: the simulation, ``engine`` or ``robosuite``.
        revision, processor: what it was computed by.
        seconds: of learning on the target, or of imitation; None where there was neither.
        outcomes: a 1 for each success and a 0 for each failure, in the order of the starts.
    """

    transfer: str
    task: str
    source: str
    source_controller: str
    target: str
    target_controller: str
    method: str
    option: str
    reward: str
    demonstrations: int
    seed: int
    env_steps: int
    starts: int
    successes: int
    judge: str
    revision: str
    processor: str
    seconds: float | None
    outcomes: str

    @property
    def key(self) -> tuple[Any, ...]:
        """What tells it from other runs; two with the same are one that was repeated."""
        return (self.transfer, self.method, self.option, self.reward, self.demonstrations,
                self.seed, self.env_steps > 0, self.judge)  # fmt: skip


@dataclass(frozen=True)
class CurvePoint:
    """Success of a run while it learns, on a few learning starts: a point of its curve."""

    transfer: str
    method: str
    option: str
    reward: str
    demonstrations: int
    seed: int
    env_steps: int
    success: float

    @property
    def key(self) -> tuple[Any, ...]:
        """Of the whole curve: a run that was repeated has been evaluated at other steps."""
        return astuple(self)[:-2]


def read_runs(path: Path = RUNS) -> list[Run]:
    """Raises DataError where the file is missing or no such table."""
    return _read(Run, path)


def read_curves(path: Path = CURVES) -> list[CurvePoint]:
    """Raises DataError where the file is missing or no such table."""
    return _read(CurvePoint, path)


def add[Row: (Run, CurvePoint)](kind: type[Row], path: Path, rows: Iterable[Row]) -> None:
    """Put rows into a table, in the place of all those with their keys, and keep it in order."""
    new = list(dict.fromkeys(rows))  # a run that two have judged brings its curve twice
    repeated = {row.key for row in new}
    known = _read(kind, path) if path.is_file() else []
    kept = [row for row in known if row.key not in repeated]
    # a curve's points have one key and keep their order
    ordered = sorted([*kept, *new], key=lambda row: row.key)
    names = [field.name for field in fields(kind)]
    with write_whole(path) as partial, partial.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, names, lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(row) for row in ordered)


def _read[Row: DataclassInstance](kind: type[Row], path: Path) -> list[Row]:
    columns = {field.name: _READERS[str(field.type)] for field in fields(kind)}
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            reader = csv.DictReader(stream)
            _check(path, reader.fieldnames or (), list(columns))
            return [kind(**{name: columns[name](row[name]) for name in columns}) for row in reader]
    except FileNotFoundError:
        raise DataError("the file is missing", file=path) from None


def _check(path: Path, found: Sequence[str], expected: Sequence[str]) -> None:
    if list(found) != list(expected):
        raise DataError("other columns", file=path, found=list(found), expected=list(expected))


def _optional(text: str) -> float | None:
    return float(text) if text else None


_READERS: dict[str, Any] = {"str": str, "int": int, "float": float, "float | None": _optional}
