"""SAC beside robosuite-benchmark's: what the sentence says, and when a figure is drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lfr.errors import DataError
from lfr.evaluation.evidence.records import read_evidence
from lfr.evaluation.evidence.reference import (
    BENCHMARK,
    read_reference,
    reference_figure,
    reference_sentence,
    returns_at,
)
from lfr.evaluation.evidence.report import report

ROOT = Path(__file__).parents[3]


def curves(path: Path, seeds: dict[int, list[tuple[int, float]]]) -> Path:
    rows = [f"{seed},{at},{value}" for seed, points in seeds.items() for at, value in points]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(["seed,env_steps,mean_return", *rows]) + "\n")
    return path


def test_sentence_by_hand(tmp_path: Path) -> None:
    ours = curves(tmp_path / "ours.csv", {0: [(0, 0), (100_010, 50)], 1: [(0, 0), (100_000, 70)]})
    theirs = curves(
        tmp_path / "theirs.csv",
        {17: [(50_000, 10), (150_000, 30), (1_050_000, 300)], 9: [(0, 0), (1_000_000, 400)]},
    )
    found = read_reference(ours, theirs)
    assert found is not None
    assert found.ends == (100_000, 1_000_000)
    assert returns_at(found.theirs, 100_000) == pytest.approx([20, 40])
    text = reference_sentence(found)
    assert "After 100 thousand environment steps" in text
    assert "here returns 60.0 (50.0 to 70.0, 2 seeds)" in text
    assert "30.0 (20.0 to 40.0, 2 seeds): every seed of ours is above" in text
    # 30 + 270 x 850 / 900 = 285
    assert "After 1 million steps theirs returns 342.5 (285.0 to 400.0, 2 seeds)." in text


def test_benchmark_is_as_measured() -> None:
    """Five seeds to a million steps. A step's reward is at most 1; late, most of 500 is there."""
    found = read_reference(ROOT / BENCHMARK, ROOT / BENCHMARK)
    assert found is not None
    assert len(found.theirs) == 5
    assert found.ends[1] == 1_000_000
    late = [returns[steps > 8e5].mean() for steps, returns in found.theirs.values()]
    assert 250 < np.mean(late) < 500
    assert all(returns.min() >= 0 and returns.max() <= 500 for _, returns in found.theirs.values())


def test_nothing_is_shown_before_the_stage_has_run(tmp_path: Path) -> None:
    evidence = read_evidence(tmp_path)
    assert evidence.reference is None
    assert "reference.svg" not in report(evidence)


def test_report_and_figure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    curves(BENCHMARK, {17: [(5_000, 6), (1_000_000, 400)]})
    curves(Path("results/paper/reference/lift-panda.csv"), {0: [(0, 2), (100_000, 90)]})
    evidence = read_evidence(Path("results/paper"))
    assert evidence.reference is not None
    text = report(evidence)
    assert "(reference.svg)" in text
    assert reference_sentence(evidence.reference) in text
    for name in ("a.svg", "b.svg"):
        reference_figure(Path(name), evidence.reference)
    assert Path("a.svg").read_bytes() == Path("b.svg").read_bytes()


def test_a_file_without_its_columns_is_refused(tmp_path: Path) -> None:
    good = curves(tmp_path / "good.csv", {0: [(0, 1)]})
    (tmp_path / "bad.csv").write_text("seed,env_steps\n0,0\n")
    with pytest.raises(DataError, match="mean_return"):
        read_reference(tmp_path / "bad.csv", good)
    with pytest.raises(DataError, match="no curve"):
        read_reference(curves(tmp_path / "none.csv", {}), good)
