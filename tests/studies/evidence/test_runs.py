"""The table of runs on disk."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from lfr.errors import DataError
from studies.evidence.runs import CurvePoint, Run, add, read_curves, read_runs
from tests.studies.evidence.made_up import run


def test_what_is_written_is_read_again_in_order(tmp_path: Path) -> None:
    path = tmp_path / "runs.csv"
    runs = [run(seed=1), run(seed=0), run(seed=0, env_steps=40_010)]
    add(Run, path, runs)
    assert read_runs(path) == sorted(runs, key=lambda one: one.key)


def test_a_repeated_run_takes_its_place_and_no_others(tmp_path: Path) -> None:
    path = tmp_path / "runs.csv"
    first = [run(), run(seed=1), run(judge="robosuite"), run(option="paper"), run(env_steps=40_010)]
    add(Run, path, first)
    again = replace(first[4], env_steps=40_002, outcomes="1111", successes=4)
    add(Run, path, [again])
    found = read_runs(path)
    assert len(found) == 5
    assert again in found
    assert first[4] not in found


def test_a_repeated_run_leaves_nothing_of_its_curve(tmp_path: Path) -> None:
    path = tmp_path / "curves.csv"
    first = [CurvePoint("t", "lfr", "ours", "sparse", 50, 0, steps, 0.5) for steps in (0, 5006)]
    other = [replace(point, seed=1) for point in first]
    add(CurvePoint, path, [*first, *other])
    again = [replace(point, success=1.0, env_steps=steps)
             for point, steps in zip(first, (0, 5011), strict=True)]  # fmt: skip
    add(CurvePoint, path, [*again, *again])  # judged by two
    assert read_curves(path) == [*again, *other]


def test_another_table_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "runs.csv"
    path.write_text("transfer,success\n")
    with pytest.raises(DataError, match="other columns"):
        read_runs(path)
    with pytest.raises(DataError, match="missing"):
        read_runs(tmp_path / "none.csv")
