"""An environment of somebody's as a simulation, against the environment itself."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from lfr.artifacts import file_hash
from lfr.data.own_columns import own_columns
from lfr.environments.simulation import (
    FAILURES,
    ExternalSimulation,
    ExternalTarget,
    external_target,
)
from lfr.errors import LfrError
from lfr.external import EnvironmentParams, ExternalArm, external
from lfr.transfer.environment import RewardRule, RunningEpisode
from tests.external import made_up, plane
from tests.external.plane import BROKEN_AT, Plane

PLANE = EnvironmentParams(
    "tests.external.plane:lfr-test/Plane-v0", observation={"observation.state": "agent_pos"}
)
NAMES = ("hand_pos.x", "hand_pos.y", "goal_pos.x", "goal_pos.y")
ORDERED = made_up.EXTERNAL.replace(  # of the column, and of what models call it, each another
    "- {column: observation.state, names: [hand_pos.x, hand_pos.y, goal_pos.x, goal_pos.y]}",
    "- {column: observation.state, dims: [2, 3, 0, 1], unit: 2, "
    "names: [goal_pos.x, goal_pos.y, hand_pos.x, hand_pos.y]}",
).replace(
    "action: {column: action}\n",
    "action: {column: action, dims: [1, 2, 3, 0], low: [-1, -1, -0.5, -1], high: [1, 1, 0.5, 1]}\n",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plane")
    made_up.write_both(folder / "data/external", episodes=2)
    return folder


def puck(folder: Path, params: EnvironmentParams = PLANE, text: str = "") -> ExternalArm:
    (folder / "params.yaml").write_text(text or made_up.EXTERNAL)
    arm = external(folder / "params.yaml").arms["puck"]
    tasks = {
        name: replace(task, path=folder / (task.path or "")) for name, task in arm.tasks.items()
    }
    return replace(arm, environments={"park": params}, tasks=tasks)


def target_of(
    folder: Path, params: EnvironmentParams = PLANE, text: str = "", names: tuple[str, ...] = NAMES
) -> ExternalTarget:
    arm = puck(folder, params, text)
    found = external_target("puck", arm, "park", ("push", "pull"), names)
    assert found is not None
    assert found.code == file_hash(Path(plane.__file__))
    return found


def simulation(folder: Path, **changes: Any) -> ExternalSimulation:
    kwargs = {key: changes.pop(key) for key in list(changes) if key in ("breaks", "drifts", "box")}
    params = replace(PLANE, kwargs=kwargs, **changes)
    columns = own_columns("puck", puck(folder, params), "park", ("push",), NAMES)
    return ExternalSimulation("puck", "park", params, columns)


def test_it_is_the_environment_itself(folder: Path) -> None:
    engine, plain = simulation(folder), gymnasium.make("lfr-test/Plane-v0")
    assert engine.layout.names == NAMES
    assert engine.horizon == 40
    rng = np.random.default_rng(0)
    for seed in (3, 4):
        seen, _ = plain.reset(seed=seed)
        np.testing.assert_array_equal(engine.reset(seed), seen["agent_pos"])
        actions = rng.uniform(-1, 1, (5, 4))
        steps = engine.step(actions)
        for action, observed, reward, success in zip(
            actions, steps.observations, steps.rewards, steps.successes, strict=True
        ):
            seen, expected, _, _, info = plain.step(np.float32(action))
            np.testing.assert_array_equal(observed, seen["agent_pos"])
            assert (reward, success) == (expected, info["is_success"])


def test_columns_units_and_order_are_the_datasets(folder: Path) -> None:
    names = (*NAMES[2:], *NAMES[:2])
    there = replace(PLANE, kwargs={"quadrant": (-1, 1)})
    wider = ORDERED.replace("low: [-1, -1, -0.5, -1]", "low: [-1, -1, -2, -1]")
    with pytest.raises(LfrError, match=r"action.3 goes from -2 to 0.5, the environment's from -1"):
        target_of(folder, there, wider, names)
    engine = target_of(folder, there, ORDERED, names).simulation()
    plane = Plane(quadrant=(-1, 1))
    seen, _ = plane.reset(seed=0)
    np.testing.assert_allclose(engine.reset(0), np.roll(seen["agent_pos"], 2) / 2, rtol=1e-6)
    steps = engine.step(np.array([[0.5, 0.25, 0.75, -1.0]]))  # speed, cos, sin, hand
    seen, *_ = plane.step(np.array([-1.0, 0.5, 0.25, 0.375]))
    np.testing.assert_allclose(steps.observations[0], np.roll(seen["agent_pos"], 2) / 2, rtol=1e-5)


def test_an_action_lasts_as_many_steps_as_a_slower_arm_has(folder: Path) -> None:
    slower = made_up.EXTERNAL.replace(
        "      action: {column: action}\n",
        "      resample: 4\n      action: {column: action, deltas: [action.1]}\n",
    )
    columns = own_columns("puck", puck(folder, text=slower), "park", ("push",), NAMES)
    assert (columns.fps, columns.ratio) == (10, 2.5)
    engine, plain = ExternalSimulation("puck", "park", PLANE, columns), Plane()
    assert (engine.horizon, engine.rate) == (16, 4.0)
    plain.reset(seed=1)
    engine.reset(1)
    actions = np.random.default_rng(2).uniform(-1, 1, (5, 4))
    steps = engine.step(actions)
    for step, (action, lasts) in enumerate(zip(actions, (3, 2, 3, 2, 3), strict=True)):
        given = [plain.step(np.float32(action)) for _ in range(lasts)]
        np.testing.assert_array_equal(steps.observations[step], given[-1][0]["agent_pos"])
        assert steps.rewards[step] == sum(float(one[1]) for one in given)
    left = engine.state()
    after = engine.step(actions[:1]).observations
    engine.set_state(left)
    np.testing.assert_array_equal(engine.step(actions[:1]).observations, after)


def test_an_episode_that_was_left_goes_on_as_if_it_had_not_been(folder: Path) -> None:
    actions = np.random.default_rng(1).uniform(-1, 1, (4, 3, 4))
    rule = RewardRule("sparse", 1.0)
    whole, left = (RunningEpisode(simulation(folder)) for _ in range(2))
    for episode in (whole, left):
        episode.start(5)
        episode.execute(actions[0], rule)
    kept = left.suspend()
    left.start(6)
    left.execute(actions[1], rule)
    again = RunningEpisode(simulation(folder))  # of another process
    for episode in (left, again):
        episode.restore(*kept)
    for skill in actions[2:]:
        expected = whole.execute(skill, rule)
        for episode in (left, again):
            found = episode.execute(skill, rule)
            np.testing.assert_array_equal(found.observation, expected.observation)
            assert found._replace(observation=0) == expected._replace(observation=0)


def test_one_that_does_not_repeat_itself_says_so(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    engine = simulation(folder, drifts=True)
    engine.reset(0)
    engine.step(np.zeros((2, 4)))
    engine.set_state(engine.state())
    assert "does not repeat itself" in caplog.text


@pytest.mark.parametrize(
    ("breaks", "said"),
    [
        ("raises", "RuntimeError: the puck has left the plane"),
        ("exits", "its process has ended, exit code 3"),
    ],
)
def test_a_crash_is_a_failed_episode(
    folder: Path, breaks: str, said: str, caplog: pytest.LogCaptureFixture
) -> None:
    engine = simulation(folder, breaks=breaks)
    for seed in range(FAILURES - 1):
        engine.reset(seed)
        steps = engine.step(np.zeros((BROKEN_AT + 3, 4)))
        assert steps.diverged
        assert len(steps) == BROKEN_AT - 1
    assert caplog.text.count(f"has failed: {said}") == FAILURES - 1
    assert ("Traceback" in caplog.text) == (breaks == "raises")
    engine.reset(FAILURES)
    with pytest.raises(LfrError, match=f"cannot go on: {said}"):
        engine.step(np.zeros((BROKEN_AT, 4)))


def test_whole_episodes_between_crashes_make_them_bearable(folder: Path) -> None:
    engine = simulation(folder, breaks=True)
    for seed in range(2 * FAILURES):
        engine.reset(seed)
        engine.step(np.zeros((BROKEN_AT - seed % 2, 4)))  # every other one ends before it breaks


@pytest.mark.parametrize("at", ["reset", "step"])
def test_one_that_does_nothing_but_raise_is_a_fault(folder: Path, at: str) -> None:
    with pytest.raises(LfrError, match=r"puck, park: the environment cannot .*: no licence"):
        target_of(folder, replace(PLANE, kwargs={"broken": at}))


def test_a_rounded_action_stays_within_its_bounds(folder: Path) -> None:
    engine = simulation(folder)
    engine._box = gymnasium.spaces.Box(-0.3, 0.3, (4,), np.float64)
    taken = engine._physical(np.ones(4))
    assert taken.dtype == np.float64
    assert engine._box.contains(taken)
    assert not engine._box.contains(np.float64(np.full(4, np.float32(0.3))))


def test_success_ends_it_or_goes_on(folder: Path) -> None:
    engine, plane = simulation(folder, box=True, observation={}), Plane()
    engine.reset(2)
    plane.reset(seed=2)
    way = plane.goal - plane.hand
    action = np.array([-1.0, 1.0, *(way / np.linalg.norm(way))])
    stopped = engine.step(np.tile(action, (40, 1)), stop_on_success=True)
    assert stopped.successes.tolist() == [False] * (len(stopped) - 1) + [True]
    assert len(stopped) < 20
    after = engine.step(np.tile(action, (3, 1)))  # the environment is over; nothing moves
    np.testing.assert_array_equal(after.observations, np.tile(stopped.observations[-1], (3, 1)))
    assert not after.rewards.any()
    assert not after.successes.any()
    rewarded = simulation(folder, success="", success_reward=1.0)
    rewarded.reset(2)
    assert rewarded.step(np.tile(action, (len(stopped), 1))).successes[-1]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"id": "nobodys_module:Plane-v0"}, "no environment 'nobodys.*ModuleNotFoundError"),
        ({"id": "lfr-test/Plain-v0"}, "no environment 'lfr-test/Plain-v0'"),
        ({"kwargs": {"colour": 1}}, "TypeError.*colour"),
        ({"observation": {}}, "observation.state is None.*which has agent_pos; say which"),
        ({"observation": {"observation.state": "pos"}}, "is 'pos' of .* which has agent_pos"),
        ({"success": "done"}, "never says 'done'; its info has is_success; name one"),
    ],
)
def test_what_is_wrong_with_it_is_one_line(
    folder: Path, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(LfrError, match=message) as error:
        target_of(folder, replace(PLANE, **changes))
    assert str(error.value).startswith("puck, park: ")
    assert "\n" not in str(error.value)
