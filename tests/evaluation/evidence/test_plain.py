"""The links with plain demonstrations beside ours: the same seeds, and no more than they say."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from lfr.evaluation.evidence.plain import (
    REFERENCES,
    identity_sentence,
    plain_section,
    plain_summary,
    plain_table,
)
from lfr.evaluation.evidence.reasons import reason_for_ap
from lfr.evaluation.evidence.records import read_evidence
from lfr.evaluation.evidence.report import report
from tests.evaluation.evidence.made_up import imitated, learned, zero_shot
from tests.evaluation.evidence.test_evidence import CAN, LIFT, cells

STACK = "s1-sawyer-stack"


@pytest.fixture
def paper(tmp_path: Path) -> Path:
    """Five seeds of ours, two plain ones: identity falls, stays, and rises."""
    zero_shot(tmp_path, CAN, {"identity": [100, 98, 0, 0, 0], "own_arm": [99] * 5, "linear": [9]})
    zero_shot(tmp_path, CAN, {"own_arm": [90, 92], "identity": [21, 25], "oracle": [88, 90]},
              "plain")  # fmt: skip
    for stage, identity in (("zero_shot", [97, 97]), ("plain", [96, 95])):
        zero_shot(tmp_path, LIFT, {"identity": identity}, stage)
    for stage, identity in (("zero_shot", [20, 20]), ("plain", [96, 95])):
        zero_shot(tmp_path, STACK, {"identity": identity}, stage)
    return tmp_path


def test_ours_stand_above_plain_of_the_same_seeds(paper: Path) -> None:
    lines = plain_table(read_evidence(paper)).splitlines()
    names = [line.split("|")[1].strip() for line in lines[2:]]
    assert names == ["`own_arm`", "", "`oracle`", "", "`identity`", ""]  # no `linear`
    (identity,) = cells("\n".join(lines), "`identity`")
    plain = cells("\n".join(lines), "")
    assert identity[1] == "ours"
    assert {row[1] for row in plain} == {"plain"}
    assert identity[4].startswith("99.0 [")  # not 39.6, of all five seeds
    assert identity[4].endswith("] (100, 98)")
    assert plain[2][4].startswith("23.0 [")
    assert plain[2][4].endswith("] (21, 25)")
    (oracle,) = cells("\n".join(lines), "`oracle`")
    assert oracle[2:] == ["-"] * 3  # it was not measured with ours


def test_identity_falls_stays_or_rises_by_intervals(paper: Path) -> None:
    assert identity_sentence(read_evidence(paper)) == (
        "With these choices set back `identity` falls on 1 of 3 tasks: Pick-Place, Sawyer (99.0 "
        "to 23.0; the source on its own arm 99.0 to 91.0). It rises on 1: Stack, Sawyer (20.0 to "
        "95.5). Its intervals overlap on 1: Lift, Panda (97.0 to 95.5).\n"
    )


def test_nothing_falls(tmp_path: Path) -> None:
    for stage in ("zero_shot", "plain"):
        zero_shot(tmp_path, LIFT, {"identity": [97, 97]}, stage)
    assert identity_sentence(read_evidence(tmp_path)) == (
        "With these choices set back `identity` falls on 0 of 1 task. Its intervals overlap on 1: "
        "Lift, Panda (97.0 to 97.0).\n"
    )


def test_the_reason_stands_beside_the_papers_figure(paper: Path) -> None:
    learned(paper, CAN, "ap", {"sparse": [95, 96]})
    disagreed = report(read_evidence(paper)).split("## Where this disagrees")[1]
    assert "Pick-Place, Sawyer: 99.0 to 23.0 (the paper's at 10.6)" in disagreed
    learned(paper, CAN, "ap", {"sparse": [20, 30], "dense": [44, 46]}, stage="learn_plain")
    disagreed = report(read_evidence(paper)).split("## Where this disagrees")[1]
    ends = r"and AP ends at 25.0 \[.*\] sparse and 45.0 \[.*\] dense \(the paper's at 10.6\)"
    assert re.search(f"Pick-Place, Sawyer: 99.0 to 23.0 {ends}", disagreed)


@pytest.mark.parametrize("stage", ["zero_shot", "plain"])
def test_one_of_the_two_alone_says_nothing(stage: str, tmp_path: Path) -> None:
    zero_shot(tmp_path, CAN, {"identity": [21, 25]}, stage)
    evidence = read_evidence(tmp_path)
    assert identity_sentence(evidence) is None
    assert reason_for_ap(evidence) is None
    assert ("not been run yet" in plain_table(evidence)) is (stage == "zero_shot")
    assert "## With our choices set back" in report(evidence)


def test_who_learned_from_plain_models_stands_beside_the_paper(paper: Path) -> None:
    for transfer, method, found in (
        (CAN, "lfr", [95, 97]), (CAN, "ap", [20, 30]), (LIFT, "lfr", [90, 92]), (LIFT, "ap", [91]),
        (STACK, "ap", [99, 99]),
    ):  # fmt: skip
        learned(paper, transfer, method, {"sparse": found}, before=9, stage="learn_plain")
    evidence = read_evidence(paper)
    section = plain_section(evidence)
    (ours,) = cells(section, "LfR")
    assert ours[1] == "sparse"
    assert ours[4].startswith("9.0 to 96.0 [")
    assert ours[4].endswith("] (95, 97)")
    assert ours[3] == "-"
    published = [row for row in cells(section, "") if row[1] == "paper"]
    assert [row[4] for row in published] == ["82.5 ± 3.2", "10.6 ± 5.7"]
    assert section.rstrip().endswith(
        "With our choices set back AP ends, by the intervals of these means, below LfR on 1: "
        "Pick-Place, Sawyer, sparse (25.0 against 96.0); not told apart from LfR on 1: Lift, "
        "Panda, sparse (91.0 against 91.0)."
    )
    assert not evidence.runs  # they are not the tables'


def test_what_rests_on_our_choices_is_said_first(paper: Path) -> None:
    for transfer, ours, plain in ((CAN, [95, 97], [20, 30]), (LIFT, [95, 97], [94, 96])):
        learned(paper, transfer, "lfr", {"sparse": ours})
        learned(paper, transfer, "lfr", {"sparse": plain}, stage="learn_plain")
    learned(paper, CAN, "ap", {"sparse": [40, 50], "dense": [30, 32]}, stage="learn_plain")
    imitated(paper, CAN, [80, 60, 100], stage="imitate_plain")
    text = plain_summary(read_evidence(paper)) or ""
    ends = {
        name: [re.sub(r" \[.*\]", "", cell) for cell in cells(text, name)[0][3:]]
        for name in ("LfR, sparse", "BC+RNN", "AP, sparse", "AP, dense", *REFERENCES.values())
    }  # the can's, without intervals
    assert ends == {
        "LfR, sparse": ["25.0", "82.5"],
        "BC+RNN": ["80.0", "16.3"],
        "AP, sparse": ["45.0", "10.6"],
        "AP, dense": ["31.0", "10.6"],
        REFERENCES["own_arm"]: ["91.0", "-"],
        REFERENCES["oracle"]: ["89.0", "-"],
    }
    assert not cells(text, "LfR, dense")
    assert cells(text, "AP, sparse")[0][1:3] == ["-", "56.6"]  # it was not run on Lift
    assert "LfR's success rests on these choices on 1 of 2 of these tasks." in text
    assert text in report(read_evidence(paper))


def test_imitation_of_plain_demonstrations_is_set_beside_ours_of_its_seeds(paper: Path) -> None:
    imitated(paper, CAN, [99, 97, 0, 0, 0])
    imitated(paper, CAN, [14, 16], "imitate_plain")
    learned(paper, CAN, "lfr", {"sparse": [95, 97]}, before=9, stage="learn_plain")
    evidence = read_evidence(paper)
    section = plain_section(evidence)
    (row,) = cells(section, "BC+RNN")
    assert row[1] == "-"
    assert len(row) == 3  # no column of a transfer that has no such runs
    assert row[2].startswith("15.0 [")  # and no beginning
    assert row[2].endswith("] (14, 16)")
    assert "BC+RNN ends, by the intervals of these means, below LfR on 1: Pick-Place" in section
    disagreed = report(evidence).split("## Where this disagrees")[1]
    assert "BC+RNN moves. Pick-Place, Sawyer: 98.0 to 15.0 (the paper's 16.3)." in disagreed
    assert [run.method for run in evidence.runs] == ["bc_rnn"] * 5
