"""The Gymnasium environments."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from lfr.errors import UnknownNameError
from lfr.sim.camera import Camera, camera_available
from lfr.sim.environment import environment_id
from lfr.sim.simulation import simulation
from lfr.tasks import TASKS
from tests.sim.pairs import EMBODIMENTS, pair, put
from tests.sim.test_simulation import goal_pose


@pytest.mark.parametrize(
    ("robot", "task"), [("panda", "lift"), ("ur5e-joint_position", "nut_assembly")]
)
def test_gymnasiums_own_check_passes(robot: str, task: str) -> None:
    check_env(gymnasium.make(environment_id(robot, task)).unwrapped, skip_render_check=True)


def test_every_embodiment_is_registered_in_every_task() -> None:
    names = [environment_id(name, task) for name in EMBODIMENTS for task in TASKS]
    assert all(name in gymnasium.registry for name in names)
    assert len(set(names)) == len(EMBODIMENTS) * len(TASKS)
    assert environment_id("ur5e-joint_position", "lift") == "lfr/Lift-UR5e-JointPosition-v0"
    assert environment_id("panda", "nut_assembly") == "lfr/NutAssembly-Panda-v0"
    assert environment_id("panda", "lift") == "lfr/Lift-Panda-v0"


def test_an_episode_is_cut_at_the_horizon_and_reports_success() -> None:
    environment = gymnasium.make("lfr/Lift-Panda-v0")
    environment.reset(seed=3)
    for step in range(1, 151):
        _, reward, terminated, truncated, info = environment.step(np.zeros(7, np.float32))
        assert not terminated
        assert truncated == (step == 150)
        assert 0 <= reward <= 1
        assert info["is_success"] is False


@pytest.mark.skipif(not camera_available(), reason="no OpenGL (libegl1)")
def test_it_draws_what_the_chosen_camera_sees() -> None:
    wanted = {"camera": "wrist", "width": 64, "height": 48}
    environment = gymnasium.make("lfr/Lift-Panda-v0", render_mode="rgb_array", **wanted)
    environment.reset(seed=3)
    engine, view = simulation("panda", "lift"), Camera("panda", "lift", "wrist", 64, 48)
    engine.reset(3)
    np.testing.assert_array_equal(environment.render(), view.render(engine))
    environment.close()
    view.close()
    with pytest.raises(UnknownNameError, match="wrist"):
        gymnasium.make("lfr/Lift-Panda-v0", camera="hand")


def test_episodes_after_a_seed_differ_and_repeat() -> None:
    environment = gymnasium.make("lfr/Stack-Sawyer-v0")
    first = [environment.reset(seed=5)[0], environment.reset()[0], environment.reset()[0]]
    again = [environment.reset(seed=5)[0], environment.reset()[0], environment.reset()[0]]
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first[1], first[2])


def test_a_diverged_episode_terminates(caplog: pytest.LogCaptureFixture) -> None:
    environment = gymnasium.make("lfr/Lift-Panda-v0").unwrapped
    environment.reset(seed=0)
    _, _, terminated, _, info = environment.step(np.full(7, np.nan, np.float32))
    assert terminated
    assert info["diverged"]
    assert "diverged" in caplog.text


@pytest.mark.parametrize(("robot", "task"), [("panda", task) for task in TASKS])
def test_the_sparse_reward_is_robosuites(robot: str, task: str) -> None:
    _, oracle = pair(robot, task, 8)
    environment = gymnasium.make(environment_id(robot, task), reward="sparse").unwrapped
    environment.reset(seed=8)
    oracle._env.reward_shaping = False
    try:
        found = []
        for moved in (False, True):
            if moved:
                for one in (environment.simulation, oracle):
                    one.step(np.zeros((10, 7)))
                pose = goal_pose(environment.simulation)
                for one in (environment.simulation, oracle):
                    put(one, pose)
            for _ in range(2):
                _, reward, _, _, info = environment.step(np.zeros(7, np.float32))
                assert reward == pytest.approx(oracle.step(np.zeros(7)).rewards[0])
                assert reward == info["is_success"]
                found.append(reward)
        assert set(found) == {0.0, 1.0}
    finally:
        oracle._env.reward_shaping = True
