"""The paper's conclusions beside made-up results: borne out, undecided, and the other way."""

from __future__ import annotations

from pathlib import Path

from lfr.evaluation.evidence.conclusions import CONCLUSIONS, conclusions_table
from lfr.evaluation.evidence.findings import verdict
from lfr.evaluation.evidence.records import read_evidence
from lfr.evaluation.evidence.targets import MARK, standing, steps_to_goal
from tests.evaluation.evidence.made_up import imitated, learned, zero_shot
from tests.evaluation.evidence.test_evidence import CAN, LIFT, cells

STACK = "s2-panda-stack"


def test_each_conclusion_is_counted(tmp_path: Path) -> None:
    for transfer, ours, ap in ((CAN, [97, 98, 99], [10, 12, 9]), (STACK, [90, 91, 93], [92] * 3)):
        learned(tmp_path, transfer, "lfr", {"sparse": ours, "dense": ours})
        learned(tmp_path, transfer, "ap", {"sparse": ap, "dense": ap}, before=80)
    learned(tmp_path, CAN, "no_generator", {"sparse": [0, 1, 2], "dense": [3, 4, 5]})
    learned(tmp_path, CAN, "only_lift", {"sparse": [100, 100, 100]})
    learned(tmp_path, CAN, "only_nut_assembly", {"sparse": [50, 51, 52]})
    table = conclusions_table(read_evidence(tmp_path))
    said = [cells(table, one.paper)[0][1] for one in CONCLUSIONS]
    assert said == [
        "than AP: so in 2, not told apart in 2 of 4",
        # straight lines: .5 to .98 and .913, against .8 to .10 and .92
        "than AP: its area is larger in 2 of 4, by -0.153 to +0.288",
        "1.0 to 4.0 in 2",
        "than only Lift: not told apart in 1 of 1; than only Nut Assembly: so in 1 of 1",
        "than only Lift: the other way in 1 of 1",
    ]


def test_nothing_measured_is_a_dash(tmp_path: Path) -> None:
    rows = conclusions_table(read_evidence(tmp_path)).splitlines()[2:]
    assert [row.split("|")[2].strip() for row in rows] == ["-"] * len(CONCLUSIONS)
    assert verdict(read_evidence(tmp_path)) is None


def test_one_failing_seed_is_marked(tmp_path: Path) -> None:
    """The interquartile mean of five does not see it; the mean does."""
    learned(tmp_path, LIFT, "lfr", {"sparse": [100] * 5})
    learned(tmp_path, LIFT, "ap", {"sparse": [100] * 5})
    imitated(tmp_path, LIFT, [98, 70, 93, 96, 99])
    place = standing(read_evidence(tmp_path), LIFT, "sparse")
    assert place is not None
    assert place.named == f"BC+RNN{MARK}, AP"
    assert abs(place.level["BC+RNN"].lead.value - 0.088) < 1e-9


def test_on_how_many_tasks_a_mapping_cannot_be_judged(tmp_path: Path) -> None:
    for transfer, dense in ((LIFT, 98), (CAN, 20)):
        learned(tmp_path, transfer, "lfr", {"sparse": [97, 98], "dense": [97, 98]})
        zero_shot(tmp_path, transfer, {"identity": [dense, dense]})
    text = verdict(read_evidence(tmp_path))
    assert text is not None
    assert (
        "**On 1 of 2 tasks LfR's interquartile mean cannot be told from that of `identity`**"
        in text
    )


def test_evaluations_of_seeds_are_taken_by_their_number(tmp_path: Path) -> None:
    """A few steps apart, as the skills under way have it: nothing is read between them."""
    learned(tmp_path, CAN, "lfr", {"sparse": [85, 100]}, before=0)
    file = tmp_path / "learn" / f"{CAN}-lfr.csv"
    rows = ["reward,seed,env_steps,updates,success,kl"]
    for seed, last in ((0, 0.85), (1, 1.0)):
        rows += [f"sparse,{seed},{at + 7 * seed},0,{rate}," for at, rate in
                 ((-7 * seed, 0.0), (100, 0.5), (200, last), (300, 0.2))]  # fmt: skip
    file.write_text("\n".join(rows) + "\n")
    runs = read_evidence(tmp_path).of(CAN, "lfr", "sparse")
    assert steps_to_goal(runs, 0.925) == 207
    assert steps_to_goal(runs, 0.93) is None
