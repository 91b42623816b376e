"""Columns chosen by a mapping, against the rows as LeRobot itself gives them; and what is odd."""

from pathlib import Path

import numpy as np
import pytest
from lerobot.datasets import LeRobotDataset

from lfr.data.external import read_external
from lfr.errors import LfrError
from lfr.external import ExternalArm, external

from . import made_up


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the datasets and params.yaml; do not write to it."""
    folder = tmp_path_factory.mktemp("external")
    made_up.write_both(folder / "data/external", episodes=2)
    (folder / "params.yaml").write_text(made_up.EXTERNAL)
    return folder


def arm(name: str, *changes: tuple[str, str]) -> ExternalArm:
    """An arm of params.yaml in the present folder, after changes to its text."""
    text = made_up.EXTERNAL
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    changed = Path.cwd() / "changed.yaml"
    changed.write_text(text)
    return external(changed).arms[name]


@pytest.fixture(autouse=True)
def there(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(place)


def test_one_task_of_a_dataset_with_dimensions_reordered_and_scaled() -> None:
    found = read_external(arm("crane"), "pull")
    oracle = LeRobotDataset("theirs/crane", root="data/external/crane")
    rows = [oracle[i] for i in range(len(oracle)) if oracle[i]["task"] == "pull it"]
    state, goal, action = (
        np.array([row[key].numpy() for row in rows])
        for key in ("observation.state", "observation.goal", "action")
    )
    assert len(rows) == 2 * made_up.LENGTH
    assert found.lengths.tolist() == [made_up.LENGTH] * 2
    np.testing.assert_allclose(
        found.observations, np.hstack([state[:, [1, 0]], goal]) / 1000, rtol=1e-6
    )
    np.testing.assert_allclose(found.actions[:, :2], action[:, :2] / 500, atol=1e-6)
    np.testing.assert_allclose(found.actions[:, 2], 2 * action[:, 2] - 1, atol=1e-6)
    np.testing.assert_allclose(
        found.action_space.physical(found.actions.numpy()), action, rtol=1e-5, atol=1e-4
    )
    assert found.observation_names == ("hand_pos.x", "hand_pos.y", "goal_pos.x", "goal_pos.y")
    assert found.action_space.names == ("vx", "vy", "hand")
    assert found.rewards is None
    assert found.successes is None
    assert found.seeds == ()


def test_a_dataset_without_names_or_instruction() -> None:
    found = read_external(arm("puck"), "push")
    oracle = LeRobotDataset("theirs/puck-push", root="data/external/puck-push")
    actions = np.array([oracle[i]["action"].numpy() for i in range(len(oracle))])
    np.testing.assert_array_equal(found.actions, actions)  # bounds of -1 and 1 change no bit
    assert found.action_space.names == tuple(f"action.{i}" for i in range(4))


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("crane", ("column: observation.goal", "column: observation.gaol"),
         r"column is missing.*crane/meta/info.json, column observation.gaol, found .*goal"),
        ("crane", ("dims: [x_mm, y_mm]", "dims: [x_mm, z_mm]"),
         r"no such dimension.*column observation.state, found y_mm, x_mm, joint, expected z_mm"),
        ("crane", ("dims: [x_mm, y_mm]", "dims: [0, 3]"), "no such dimension.*expected 3"),
        ("crane", ("names: [goal_pos.x, goal_pos.y]", "names: [goal_pos.x]"),
         "another number of names.*observation.goal, found 1 names, expected 2: gx, gy"),
        ("crane", ("names: [goal_pos.x, goal_pos.y]", "names: [hand_pos.x, goal_pos.y]"),
         "one name.*hand_pos.x"),
        ("crane", ("names: [goal_pos.x, goal_pos.y]", "names: [goal_pos.x, far]"),
         r"`number.<name>` and `joint.<name>` .*column observation.goal, found far, "
         r"expected one of eef_pos, .*<thing>_pos"),
        ("crane", ("names: [goal_pos.x, goal_pos.y]", "names: [goal_rot6d.0, goal_rot6d.1]"),
         "does not say what it is.*found goal_rot6d.0"),
        ("crane", ("fps: 10", "cartesian: true\n      fps: 10"),
         "does not say what it is.*column action, found vx"),
        ("crane", ("low: [-500, -500, 0]", "low: [-500, 0]"), "under 'low'.*found 2, expected 3"),
        ("crane", ("low: [-500, -500, 0]", "low: [-500, 500, 0]"), "bound nothing for 'vy'"),
        ("crane", ("low: [-500, -500, 0]", "low: [-100, -500, 0]"),
         r"actions beyond low and high.*action, dimension vx.*expected -100 to 500"),
        ("crane", ("fps: 10", "fps: 20"), "another fps.*found 10, expected 20"),
        ("crane", ("robot_type: crane", "robot_type: digger"), "another robot.*found crane"),
        ("crane", ("instruction: pull it", "instruction: Pull it"),
         "no episode is of this task.*found 'park it', 'pull it', 'push it', expected 'Pull it'"),
        ("crane", ("path: data/external/crane", "path: data/external/none"), "no such dataset"),
        ("crane", ("column: action,", "column: timestamp,"), "under 'low'.*found 3, expected 1"),
    ],
)  # fmt: skip
def test_what_is_missing_or_odd_is_named_in_one_line(
    name: str, change: tuple[str, str], message: str
) -> None:
    with pytest.raises(LfrError, match=message) as caught:
        read_external(arm(name, change), "pull")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("    crane:\n", "    panda:\n"), "panda is an arm that this project simulates"),
        (("unit: 1000", "unit: 0"), r"observation\[0\].*unit must not be 0"),
        (("dims: [x_mm, y_mm]", "dims: [x_mm]"), "found 2 names for 1 dims"),
        (("path: data/external/crane\n", "robot: x\n"), "unknown parameter 'robot'; valid: fps"),
        (("{path: data/external/puck-push}", "{}"), "puck: no path for task 'push'"),
        (("fps: 10\n      robot_type", "robot_type"), "parameter 'fps' is missing"),
    ],
)
def test_a_mapping_that_contradicts_itself(change: tuple[str, str], message: str) -> None:
    with pytest.raises(LfrError, match=message):
        arm("puck", change)
