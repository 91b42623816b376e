"""The seconds of a stage, over the processes that shared its work."""

import time
from pathlib import Path

import pytest

from lfr.artifacts import read_json
from pipeline.paper import _spent
from pipeline.paper._spent import Spent


def test_a_later_process_adds_to_what_earlier_ones_took(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(_spent, "TICK", 3600.0)  # two processes do not share the work at one time
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.setattr(_spent, "BEGAN", time.perf_counter() - 100.0)
    Spent(work).write("learn", "first", {"runs": []})
    first = read_json(Path("results/paper/learn/first.json"))
    assert 100.0 <= first["seconds"] < 130.0
    assert first["runs"] == []
    assert set(first) == {"runs", "seconds", "peak_memory", "provenance"}
    monkeypatch.setattr(_spent, "BEGAN", time.perf_counter() - 7.0)
    Spent(work).write("learn", "again", {})
    again = read_json(Path("results/paper/learn/again.json"))
    assert 107.0 <= again["seconds"] < first["seconds"] + 30.0


def test_a_killed_process_has_left_its_seconds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_spent, "TICK", 0.01)
    monkeypatch.setattr(_spent, "BEGAN", time.perf_counter() - 50.0)
    Spent(tmp_path)
    for _ in range(500):
        if (tmp_path / "spent.json").is_file():
            break
        time.sleep(0.01)
    assert read_json(tmp_path / "spent.json")["seconds"] >= 50.0
