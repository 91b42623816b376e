"""`lfr record` in somebody's environment, against the environment itself and LeRobot's reader."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from lerobot.datasets import LeRobotDataset

from lfr.cli import main
from lfr.data.external import read_external
from lfr.data.log_reader import list_logs, read_log
from lfr.external import external
from tests.external.plane import STEP, Plane

HERE = "tests.external.test_recording"
PARAMS = """
external:
  arms:
    puck:
      fps: 10
      observation:
        - {column: observation.state, names: [hand_pos.x, hand_pos.y, goal_pos.x, goal_pos.y]}
      action: {column: action, names: [hand, speed, cos, sin]}
      tasks: {park: {path: data/external/puck-park, instruction: park it}}
      environments:
        park:
          id: tests.external.plane:lfr-test/Plane-v0
          kwargs: {KWARGS}
          observation: {observation.state: agent_pos}
"""


def straight() -> Callable[[Any], Any]:
    """Straight to the goal, more than the bounds allow."""
    return _straight


def _straight(observed: dict[str, Any]) -> Any:
    way = observed["agent_pos"][2:] - observed["agent_pos"][:2]
    distance = np.linalg.norm(way)
    return [3.0, 2.0 * min(distance / STEP, 1.0) - 1.0, *(way / distance)]


class Meek:
    """A policy as Meta-World has them, which does nothing."""

    def get_action(self, observed: Any) -> Any:
        return np.array([0.0, -1.0, 1.0, 0.0])


def several() -> Callable[[Any], Any]:
    return lambda observed: [0.0, 0.0]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "params.yaml").write_text(PARAMS.replace("KWARGS", ""))
    return tmp_path


def record(
    *more: str, policy: str = f"{HERE}:straight", to: str = "data/external/puck-park"
) -> int:
    return main(["record", "puck", "park", "--policy", policy, "--to", to, *more])


def test_what_is_recorded_is_the_episode(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert record("--episodes", "3", "--noise", "0.2", "--linger", "0.3") == 0
    assert "0 of 3 attempts failed" in capsys.readouterr().out
    dataset = LeRobotDataset("lfr/puck-park", root=folder / "data/external/puck-park")
    assert (dataset.num_episodes, dataset.fps) == (3, 10)
    assert dataset.features["action"]["names"] == ["hand", "speed", "cos", "sin"]
    logs, row = list_logs(folder / "data/logs/puck-park"), 0
    for log in logs:
        episode, plane = read_log(log), Plane()
        assert episode.metadata["fps"] == 10
        assert episode.executed_action is not None
        seen, _ = plane.reset(seed=episode.seed)
        reached: list[bool] = []
        for t, executed in enumerate(episode.executed_action):
            frame = dataset[row]
            np.testing.assert_array_equal(frame["observation.state"], seen["agent_pos"])
            wanted = np.clip(
                _straight(seen), -1.0, 1.0
            )  # the label is clean, and can be carried out
            np.testing.assert_allclose(frame["action"], wanted, atol=1e-6)
            assert np.abs(executed).max() <= 1.0
            seen, _, _, _, info = plane.step(np.float32(executed))
            assert frame["next.success"] == info["is_success"]
            assert frame["task"] == "park it"
            reached.append(bool(info["is_success"]))
            row += 1
            assert t < 40
        assert sum(reached) == 1  # this environment ends where it succeeds
        assert (episode.executed_action != episode.features["action"]).any()
    assert row == dataset.num_frames
    found = read_external(external().arms["puck"], "park")
    assert found.observation_names == ("hand_pos.x", "hand_pos.y", "goal_pos.x", "goal_pos.y")
    assert main(["verify", "data/external/puck-park"]) == 0
    assert main(["verify", "data/logs/puck-park"]) == 0
    assert main(["view", "data/external/puck-park", "--save", "puck.rrd"]) == 0


def test_the_same_again_is_the_same_bytes(folder: Path) -> None:
    for name in ("a", "b"):
        assert record("--episodes", "1", "--logs", name, "--noise", "0.1", to=f"{name}-set") == 0
    for first, second in zip(list_logs(Path("a")), list_logs(Path("b")), strict=True):
        assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize(
    ("policy", "kwargs", "message"),
    [
        (
            f"{HERE}:Meek",
            "",
            "Meek succeeded in 0 of 1 attempts at park on puck; expected 1",
        ),
        (f"{HERE}:several", "", "several answers .* expected Box"),
        (f"{HERE}:nobody", "", "has no attribute 'nobody'; expected module:name"),
        ("nobodys_module:x", "", "No module named 'nobodys_module'; expected module:name"),
        (f"{HERE}:straight", "broken: reset", "0 of 1 attempts"),
        (f"{HERE}:straight", "colour: 1", "no environment 'tests.external.plane.*colour"),
    ],
)
def test_what_is_wrong_is_one_line_and_nothing_is_written(
    folder: Path, policy: str, kwargs: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "params.yaml").write_text(PARAMS.replace("KWARGS", kwargs))
    assert record("--episodes", "1", "--attempts", "1", policy=policy) == 2
    error = capsys.readouterr().err.splitlines()[-1]
    assert error.startswith("lfr: error: ")
    assert re.search(message, error)
    assert not (folder / "data/external/puck-park").exists()


def test_an_arm_or_environment_that_there_is_not(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    common = ["--policy", f"{HERE}:straight", "--to", "x"]
    assert main(["record", "crane", "park", *common]) == 2
    assert "unknown external arm 'crane'" in capsys.readouterr().err
    assert main(["record", "puck", "push", *common]) == 2
    assert "unknown environment for task 'push'" in capsys.readouterr().err


def test_a_crash_costs_its_attempt(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "params.yaml").write_text(PARAMS.replace("KWARGS", "breaks: exits"))
    assert record("--episodes", "1", "--attempts", "1") == 2
    assert "0 of 1 attempts" in capsys.readouterr().err


def test_a_policy_beside_params_is_found_and_what_is_converted_lends_no_name(folder: Path) -> None:
    """By the command itself, whose path does not hold the folder that it is called in."""
    (folder / "mine.py").write_text(f"from {HERE} import straight\n")
    text = PARAMS.replace("KWARGS", "").replace("goal_pos.y]}", "goal_pos.y], unit: cm}")
    (folder / "params.yaml").write_text(text)
    lfr = Path(sys.executable).with_name("lfr")
    root = str(Path(__file__).parents[2])  # of the tests' environment
    told = subprocess.run(
        [lfr, "record", "puck", "park", "--policy", "mine:straight", "--to", "shown",
         "--episodes", "1"],
        cwd=folder, env={**os.environ, "PYTHONPATH": root}, capture_output=True, text=True,
    )  # fmt: skip
    assert told.returncode == 0, told.stderr
    dataset = LeRobotDataset("lfr/shown", root=folder / "shown")
    names = dataset.features["observation.state"]["names"]
    assert names == ["state.0", "state.1", "state.2", "state.3"]


def test_pictures_are_recorded_where_it_draws(folder: Path) -> None:
    gymnasium.make("lfr-test/Plane-v0", render_mode="rgb_array")
    (folder / "params.yaml").write_text(PARAMS.replace("KWARGS", "render_mode: rgb_array"))
    assert record("--episodes", "1") == 0
    dataset = LeRobotDataset("lfr/puck-park", root=folder / "data/external/puck-park")
    assert dataset[0]["observation.images.render"].shape == (3, 32, 48)
