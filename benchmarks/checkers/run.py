"""One run of the benchmark, which goes on where an earlier one was stopped."""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Iterator
from pathlib import Path

from benchmarks._datasets import Size, write_dataset
from benchmarks.checkers.bases import NAMES, make_bases
from benchmarks.checkers.faults import FAULTS, plant
from benchmarks.checkers.findings import Said
from benchmarks.checkers.peers import CHECKERS, NOT_RUN, Checker
from benchmarks.checkers.results import CLEAN, Row, judged, of_clean, read_rows, write_rows
from lfr.errors import LfrError

IN_VIDEOS = ("video", "pictures")
"""Groups of faults for which a checker is to look into the videos."""


class Run:
    """The clean datasets, the checkers, and the rows that there are.

    Attributes:
        checkers, versions: those that could be installed.
        refused: those that could not, or are not to be run, and why.
        rows: by fault and checker.
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self.work: Path = options.work
        self.table: Path = options.out / "checkers.csv"
        self.work.mkdir(parents=True, exist_ok=True)
        make_bases(self.work / "bases", options.dataset, options.logs)
        self.checkers: dict[str, Checker] = {}
        self.versions: dict[str, str] = {}
        self.refused = dict(NOT_RUN)
        for name in options.only or CHECKERS:
            try:
                self.versions[name] = CHECKERS[name].install(self.work)
                self.checkers[name] = CHECKERS[name]
            except LfrError as error:
                self.refused[name] = str(error)
                print(f"{name} is not run: {error}", flush=True)
        self.rows: dict[tuple[str, str], Row] = {
            (row.fault, row.checker): row
            for row in read_rows(self.table)
            if (row.fault in FAULTS or row.group == CLEAN) and row.checker in CHECKERS
        }
        self._clean: dict[tuple[str, str, bool], Said] = {}

    def missing(self, name: str, *, again: bool) -> Iterator[Checker]:
        """Checkers of which there is no row for a fault or clean dataset, or another version's."""
        for checker, version in self.versions.items():
            row = self.rows.get((name, checker))
            if again or row is None or row.version != version:
                yield self.checkers[checker]

    def fault(self, name: str, checkers: list[Checker]) -> None:
        """Plant a fault, and write down what these checkers make of it."""
        fault, out = FAULTS[name], self.work / "planted" / name
        pictures = fault.group in IN_VIDEOS or name.startswith("video")
        copy, planted = None, None
        for checker in checkers:
            if copy is None or _state(out) != planted:  # one before has written there
                copy = plant(name, self.work / "bases", out)
                planted = _state(out)
            found = checker.run(self.work, out, pictures=pictures, logs=copy.logs)
            clean = self._of_base(fault.base, checker, pictures)
            self._note(judged(name, checker.name, self.versions[checker.name], clean, found))
        for place in out.parent.glob(f"{name}*"):
            shutil.rmtree(place) if place.is_dir() else place.unlink()

    def clean(self, name: str, dataset: Path, checkers: list[Checker]) -> None:
        """Write down what these checkers say of a dataset in which nothing is wrong."""
        for checker in checkers:
            if name in NAMES:
                said = self._of_base(name, checker, pictures=True)
            else:
                said = checker.run(self.work, dataset, pictures=True)
            self._note(of_clean(name, checker.name, self.versions[checker.name], said))

    def seconds(self) -> dict[str, float]:
        """Processor time of each checker for 1,000 state-only episodes."""
        dataset = self.work / "thousand"
        if not dataset.is_dir():
            write_dataset(dataset, Size(1000))
        found = {}
        for name, checker in self.checkers.items():
            said, spent = checker.timed(self.work, dataset, pictures=False)
            if not said.crash:
                found[name] = round(spent, 1)
            print(f"{spent:7.1f} s {name} {said.crash}", flush=True)
        return found

    def _of_base(self, base: str, checker: Checker, pictures: bool) -> Said:
        key = (base, checker.name, pictures and bool(checker.pictures))
        if key not in self._clean:
            place = self.work / "bases" / base
            self._clean[key] = checker.run(self.work, place, pictures=pictures)
        return self._clean[key]

    def _note(self, row: Row) -> None:
        self.rows[row.fault, row.checker] = row
        write_rows(self.table, self.rows.values())
        print(f"{row.result:7s} {row.checker:14s} {row.fault:30s} {row.finding[:100]}", flush=True)


def _state(root: Path) -> list[tuple[str, int, int]]:
    """Of each file its name, size and time: what changes when someone writes there."""
    files = [place for place in sorted(root.rglob("*")) if not place.is_dir()]
    return [(str(f), f.lstat().st_size, f.lstat().st_mtime_ns) for f in files]
