"""The measured success of the scripted expert: the goals, and the exceptions by name."""

import pytest

from benchmarks import experts
from benchmarks._figures import FOLDER
from lfr.artifacts import read_json
from lfr.evaluation.marked import shown
from tests.sim.pairs import EMBODIMENTS

GOALS = {"lift": 0.95, "stack": 0.95, "pick_place": 0.95, "nut_assembly": 0.85}
BELOW = {
    ("panda-joint_position", "pick_place"),
    ("sawyer-joint_position", "pick_place"),
    ("ur5e", "stack"),
    ("ur5e", "pick_place"),
    ("ur5e-joint_position", "pick_place"),
    ("iiwa", "stack"),
    ("iiwa", "pick_place"),
    ("iiwa-joint_position", "stack"),
    ("iiwa-joint_position", "pick_place"),
    ("iiwa-joint_position", "nut_assembly"),
    ("kinova3", "pick_place"),
    ("kinova3-joint_position", "pick_place"),
    ("xarm7", "nut_assembly"),
    ("xarm7-joint_position", "pick_place"),
    ("jaco", "pick_place"),
    ("jaco", "nut_assembly"),
    ("jaco-joint_position", "stack"),
    ("jaco-joint_position", "nut_assembly"),
}
"""Where the expert was measured below its goal, most of them within the interval of 50 attempts;
docs/simulation.md says more."""


@pytest.fixture(scope="module")
def rows() -> list[dict]:
    return read_json(FOLDER / "experts.json")["trials"]


def test_every_embodiment_is_measured_at_every_task(rows: list[dict]) -> None:
    measured = {(row["embodiment"], row["task"]) for row in rows if row["condition"] == "recorded"}
    assert measured == {(name, task) for name in EMBODIMENTS for task in GOALS}


def test_the_goals_are_reached_but_for_the_named_exceptions(rows: list[dict]) -> None:
    found = {
        (row["embodiment"], row["task"])
        for row in rows
        if row["condition"] == "recorded"
        and row["successes"] < GOALS[row["task"]] * row["attempts"]
    }
    assert found == BELOW


def test_the_page_shows_what_was_measured(rows: list[dict]) -> None:
    assert shown(experts.PAGE, experts.MARKER) == experts.table(rows)
