"""What an action does to what is observed, of made-up arms of which it is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lfr.cli import main
from lfr.importing.relations import Relation, relations
from tests.external import made_up

ROWS, EPISODES = 400, 4


@pytest.fixture
def arm() -> tuple[np.ndarray, dict[str, np.ndarray], np.ndarray]:
    """A joint that follows its commanded position, one that is moved by changes, a gripper that
    is commanded at random; and what was commanded among what is observed."""
    rng = np.random.default_rng(0)
    episodes = np.repeat(np.arange(EPISODES), ROWS // EPISODES)
    target = np.sin(np.arange(ROWS) / 9) + 0.02 * rng.normal(size=ROWS)
    joint = np.concatenate([[0.0], target[:-1]]) + 0.01 * rng.normal(size=ROWS)
    change = rng.uniform(-1, 1, ROWS)
    moved = np.zeros(ROWS)
    for row in range(1, ROWS):
        same = episodes[row] == episodes[row - 1]
        moved[row] = moved[row - 1] + 0.05 * change[row - 1] if same else rng.uniform(-9, 9)
    gripper = rng.choice([-1.0, 1.0], ROWS)
    action = np.stack([target, change, gripper, np.ones(ROWS)], axis=1)
    before = np.concatenate([np.zeros((1, 4)), action[:-1]])
    observed = {"state": np.stack([moved, joint, rng.normal(size=ROWS)], axis=1),
                "told": action[:, :3].copy(), "before": before[:, 1:3]}  # fmt: skip
    return action, observed, episodes


def test_each_is_told(arm: tuple[np.ndarray, dict[str, np.ndarray], np.ndarray]) -> None:
    action, observed, episodes = arm
    found = relations(action, observed, episodes)
    told = {(one.action, one.column, one.place): one for one in found}
    assert told[0, "told", 0].kind == told[1, "told", 1].kind == "copy"
    assert told[2, "told", 2].kind == "copy"
    assert told[1, "before", 0].kind == told[2, "before", 1].kind == "previous"
    position, change = told.pop((0, "state", 1)), told.pop((1, "state", 0))
    assert (position.kind, change.kind) == ("position", "change")
    assert position.explained > 0.99
    assert change.scale == pytest.approx(0.05)
    assert change.explained == pytest.approx(1.0)
    assert {one.kind for one in told.values()} == {"copy", "previous"}


def test_nothing_is_told_of_noise_or_of_what_never_changes() -> None:
    rng = np.random.default_rng(1)
    action = np.stack([rng.normal(size=ROWS), np.ones(ROWS)], axis=1)
    observed = {"state": rng.normal(size=(ROWS, 3)), "still": np.ones((ROWS, 1))}
    assert relations(action, observed, np.zeros(ROWS, int)) == list[Relation]()


def test_lfr_columns_says_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made_up.write_both(tmp_path, episodes=2)
    assert main(["columns", str(tmp_path / "crane")]) == 0
    said = capsys.readouterr().out
    # mm/s at 10 Hz move the hand by a tenth of a millimetre for each mm/s
    assert "# vx: a change or speed of x_mm of observation.state, 0.1 a step for 1 (100 %" in said
    assert '# with `resample` on the arm: deltas: ["vx", "vy"]' in said
