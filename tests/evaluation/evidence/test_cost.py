"""Hours of the evidence, counted by hand: a stage of `made_up` takes half an hour."""

from __future__ import annotations

from pathlib import Path

import pytest

from lfr.evaluation.evidence.cost import hours, hours_of_tables, time_of_tables
from lfr.evaluation.evidence.records import read_evidence
from tests.evaluation.evidence.made_up import imitated, learned, zero_shot

LIFT, CAN = "s1-panda-lift", "s2-sawyer-pick_place"


@pytest.fixture
def paper(tmp_path: Path) -> Path:
    learned(tmp_path, LIFT, "lfr", {"sparse": [90, 90, 90], "dense": [90]})
    learned(tmp_path, CAN, "spirl", {"sparse": [0]})
    imitated(tmp_path, LIFT, [80])
    zero_shot(tmp_path, LIFT, {"identity": [90]})
    return tmp_path


def test_what_is_in_no_table_does_not_count_for_the_tables(paper: Path) -> None:
    evidence = read_evidence(paper)
    assert hours(evidence) == pytest.approx(2.0)
    assert hours_of_tables(evidence) == pytest.approx(1.0)


def test_one_reward_has_the_share_of_its_runs(paper: Path) -> None:
    evidence = read_evidence(paper)
    assert hours_of_tables(evidence, "sparse") == pytest.approx(0.5 + 0.75 * 0.5)
    assert hours_of_tables(evidence, "dense") == pytest.approx(0.5 + 0.25 * 0.5)
    assert "1.00 (with one reward alone, as in the paper: 0.88 with the sparse, 0.62" in (
        time_of_tables(evidence)
    )
