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


def test_curves_are_kept_by_step(tmp_path: Path) -> None:
    path = tmp_path / "curves.csv"
    point = CurvePoint("t", "lfr", "ours", "sparse", 50, 0, 0, 0.5)
    add(CurvePoint, path, [point, replace(point, env_steps=5_000, success=0.75)])
    add(CurvePoint, path, [replace(point, success=0.25)])
    assert [(one.env_steps, one.success) for one in read_curves(path)] == [(0, 0.25), (5000, 0.75)]


def test_another_table_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "runs.csv"
    path.write_text("transfer,success\n")
    with pytest.raises(DataError, match="other columns"):
        read_runs(path)
    with pytest.raises(DataError, match="missing"):
        read_runs(tmp_path / "none.csv")
