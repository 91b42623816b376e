"""The leak rule, written out by hand for both scenarios, and the lookups' answers."""

from pathlib import Path

import pytest

from lfr.errors import LfrError, ParameterError, UnknownNameError
from lfr.scenarios import (
    ROLES,
    Scenario,
    check_visible,
    scenario,
    scenarios,
    transfer,
    transfers,
    visible_tasks,
)

PARAMS = """
scenarios:
  s1: {common: [pick_place, nut_assembly], new: {panda: lift, sawyer: stack}}
  s2: {common: [lift, nut_assembly], new: {panda: stack, sawyer: pick_place}}
"""

# (scenario, robot) -> role -> tasks, from the paper's text (section V.A) and not from the code
SEEN = {
    ("s1", "panda"): {
        "source": {"pick_place", "nut_assembly", "stack"},
        "target": {"pick_place", "nut_assembly"},
        "oracle": {"pick_place", "nut_assembly", "lift"},
    },
    ("s1", "sawyer"): {
        "source": {"pick_place", "nut_assembly", "lift"},
        "target": {"pick_place", "nut_assembly"},
        "oracle": {"pick_place", "nut_assembly", "stack"},
    },
    ("s2", "panda"): {
        "source": {"lift", "nut_assembly", "pick_place"},
        "target": {"lift", "nut_assembly"},
        "oracle": {"lift", "nut_assembly", "stack"},
    },
    ("s2", "sawyer"): {
        "source": {"lift", "nut_assembly", "stack"},
        "target": {"lift", "nut_assembly"},
        "oracle": {"lift", "nut_assembly", "pick_place"},
    },
}


@pytest.fixture
def params(tmp_path: Path) -> Path:
    path = tmp_path / "params.yaml"
    path.write_text(PARAMS)
    return path


@pytest.mark.parametrize(("name", "robot"), SEEN)
def test_who_may_see_what(params: Path, name: str, robot: str) -> None:
    known = scenario(name, params)
    for role in ROLES:
        assert set(visible_tasks(known, robot, role)) == SEEN[name, robot][role]


def test_the_targets_new_task_reaches_the_oracle_alone(params: Path) -> None:
    for known in transfers(params).values():
        home = scenario(known.scenario, params)
        check_visible(home, known.target, "oracle", [known.task])
        for role in ("source", "target"):
            with pytest.raises(LfrError, match=f"{known.task}.*by {known.target} are hidden"):
                check_visible(home, known.target, role, [*known.common, known.task])


def test_four_transfers_named_by_scenario_target_and_task(params: Path) -> None:
    sources = {name: known.source for name, known in transfers(params).items()}
    assert sources == {
        "s1-panda-lift": "sawyer",
        "s1-sawyer-stack": "panda",
        "s2-panda-stack": "sawyer",
        "s2-sawyer-pick_place": "panda",
    }
    assert transfer("s2-panda-stack", params).common == ("lift", "nut_assembly")


def test_unknown_names_are_answered_with_the_valid_ones(params: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"unknown scenario 's3'; valid: s1, s2$"):
        scenario("s3", params)
    with pytest.raises(UnknownNameError, match=r"unknown transfer 's1-panda-stack'; valid: s1-pan"):
        transfer("s1-panda-stack", params)
    with pytest.raises(UnknownNameError, match=r"unknown robot of scenario x 'ur5'; valid: panda"):
        visible_tasks(
            Scenario("x", ("lift",), {"panda": "stack", "sawyer": "lift"}), "ur5", "source"
        )
    with pytest.raises(UnknownNameError, match=r"unknown role 'thief'; valid: source, target, ora"):
        visible_tasks(scenario("s1", params), "panda", "thief")


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("{common: [lift], new: {panda: stack, pando: pick_place}}", "unknown robot 'pando'"),
        ("{common: [lift], new: {panda: stack, sawyer: juggle}}", "unknown task 'juggle'"),
        ("{common: [lift], new: {panda: stack}}", "found 1 robots under 'new', expected two"),
        ("{common: [lift], new: {panda: lift, sawyer: stack}}", "lift named twice"),
        ("{common: [], new: {panda: lift, sawyer: stack}}", "'common' names no task"),
        ("{common: [lift], news: {}}", "scenarios.bad: unknown parameter 'news'; valid: common"),
    ],
)
def test_a_scenario_that_contradicts_itself(tmp_path: Path, entry: str, message: str) -> None:
    path = tmp_path / "params.yaml"
    path.write_text(f"scenarios:\n  bad: {entry}\n")
    with pytest.raises(LfrError, match=message):
        scenarios(path)


def test_no_scenarios(tmp_path: Path) -> None:
    path = tmp_path / "params.yaml"
    path.write_text("record: {episodes: 50}\n")
    with pytest.raises(ParameterError, match="no section 'scenarios'"):
        scenarios(path)
