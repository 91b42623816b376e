"""The environments as LeRobot's scripts see them, against the engine and the datasets' schema."""

from typing import Any

import numpy as np
import pytest
from lerobot.envs import make_env, preprocess_observation
from lerobot.envs.utils import NEW_ROLLOUT_OPTION, env_to_policy_features

from lfr.embodiments import embodiment
from lfr.errors import LfrError, ParameterError, UnknownNameError
from lfr.lerobot_plugin import environment as module
from lfr.lerobot_plugin.env_config import LfrEnv
from lfr.lerobot_plugin.environment import LeRobotEnvironment
from lfr.robots import ROBOTS
from lfr.seeds import FIRST, use_of_seed
from lfr.sim.camera import camera_available, open_cameras
from lfr.sim.camera_params import CameraParams
from lfr.sim.simulation import simulation
from lfr.tasks import TASKS

CAMERAS = [CameraParams(), CameraParams("wrist", 64, 48)]


def batch(n: int, **options: Any) -> Any:
    return make_env(LfrEnv(**{"robot": "panda", "task": "lift", **options}), n_envs=n)["lfr"][0]


def start(environments: Any, *seeds: int) -> dict[str, Any]:
    options = {NEW_ROLLOUT_OPTION: True}
    return environments.reset(seed=list(seeds), options=options)[0]


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("task", TASKS)
def test_a_seed_is_the_number_of_a_held_out_start(robot: str, task: str) -> None:
    environments = batch(2, robot=robot, task=task)
    observation = preprocess_observation(start(environments, 0, 7))
    for i, index in enumerate((0, 7)):
        expected = simulation(robot, task).reset(FIRST["held-out"] + index)
        parts = [observation[f"observation.{name}"][i] for name in ("state", "environment_state")]
        np.testing.assert_array_equal(np.concatenate(parts), expected.astype(np.float32))


def test_the_seeds_of_another_use() -> None:
    environment = LeRobotEnvironment("panda", "lift", seeds="learning")
    assert environment.reset(seed=4)[1]["seed"] == FIRST["learning"] + 4
    assert use_of_seed(environment.reset()[1]["seed"]) == "learning"
    with pytest.raises(LfrError, match="held-out"):
        LeRobotEnvironment("panda", "lift").reset(seed=FIRST["held-out"])


@pytest.mark.parametrize("task", TASKS)
def test_features_are_those_of_the_datasets(task: str) -> None:
    from lfr.data.episode import FEATURES

    features = env_to_policy_features(LfrEnv(robot="panda", task=task, cameras=CAMERAS))
    recorded = {feature.key for feature in FEATURES}
    cameras = {"observation.images.agentview", "observation.images.wrist"}
    assert set(features) == cameras | (
        recorded & {"observation.state", "observation.environment_state", "action"}
    )
    assert features["observation.state"].shape == (11,)
    names = TASKS[task].environment.names
    assert features["observation.environment_state"].shape == (len(names),)
    assert features["observation.images.agentview"].shape == (3, 128, 128)
    assert features["observation.images.wrist"].shape == (3, 48, 64)


@pytest.mark.parametrize("robot", ["panda", "panda-joint_position"])
def test_an_action_is_the_embodiments(robot: str) -> None:
    size = embodiment(robot).action.size
    features = env_to_policy_features(LfrEnv(robot=robot, task="lift"))
    assert features["action"].shape == (size,)
    environments = batch(1, robot=robot)
    start(environments, 0)
    observation = environments.step(np.full((1, size), 0.1, np.float32))[0]
    expected = simulation(robot, "lift")
    expected.reset(FIRST["held-out"])
    moved = expected.step(np.full((1, size), np.float32(0.1))).observations[0]
    np.testing.assert_array_equal(observation["agent_pos"][0], moved[:11])


def test_an_episode_is_cut_at_the_horizon_and_waits() -> None:
    environments = batch(1)
    start(environments, 0)
    still = np.zeros((1, 7), np.float32)
    assert environments.call("_max_episode_steps") == (TASKS["lift"].horizon,)
    for step in range(1, 151):
        observation, _, terminated, truncated, _ = environments.step(still)
        assert not terminated[0]
        assert truncated[0] == (step == 150)
    after = environments.step(still)[0]
    np.testing.assert_array_equal(after["agent_pos"], observation["agent_pos"])
    again = start(environments, 0)
    assert not np.array_equal(again["agent_pos"], observation["agent_pos"])


def test_what_vision_language_policies_ask_for() -> None:
    environments = batch(1, robot="sawyer", task="nut_assembly")
    assert environments.call("task_description") == (TASKS["nut_assembly"].instruction,)
    assert environments.call("task") == ("lfr/NutAssembly-Sawyer-v0",)
    assert environments.unwrapped.metadata["render_fps"] == 20


@pytest.mark.skipif(not camera_available(), reason="no OpenGL")
def test_the_pictures_observed_are_those_drawn() -> None:
    environments = batch(1, cameras=CAMERAS)
    observation = preprocess_observation(start(environments, 0))
    engine = simulation("panda", "lift")
    engine.reset(FIRST["held-out"])
    views = open_cameras("panda", "lift", CAMERAS)
    for view in views:
        picture = observation[f"observation.images.{view.name}"]
        drawn = view.render(engine)
        assert drawn.std() > 10
        expected = drawn.transpose(2, 0, 1)[None] / np.float32(255)
        np.testing.assert_array_equal(picture.numpy(), expected)
    np.testing.assert_array_equal(environments.envs[0].render(), views[0].render(engine))
    for each in (environments, *views):
        each.close()


def test_cameras_are_said_as_in_params_yaml() -> None:
    import draccus

    said = "--cameras=[{name: agentview}, {name: wrist, width: 64, height: 48}]"
    found = draccus.parse(LfrEnv, args=["--robot=panda", "--task=lift", said])
    assert found.cameras == CAMERAS
    with pytest.raises(ParameterError, match="wrist more than once"):
        LfrEnv(robot="panda", task="lift", cameras=[CAMERAS[1]] * 2)


def test_without_opengl_videos_are_black(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("lfr.sim.camera.camera_available", lambda: False)
    module._seeing.cache_clear()
    environment = LeRobotEnvironment("panda", "lift")
    environment.reset(seed=0)
    pictures = [environment.render() for _ in range(2)]
    module._seeing.cache_clear()
    assert all(picture.shape == (128, 128, 3) and not picture.any() for picture in pictures)
    assert len([line for line in caplog.messages if "OpenGL" in line]) == 1


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({}, ParameterError),
        ({"robot": "panda"}, ParameterError),
        ({"robot": "pandas", "task": "lift"}, UnknownNameError),
        ({"robot": "panda", "task": "Lift"}, UnknownNameError),
        ({"robot": "panda", "task": "lift", "reward": "some"}, UnknownNameError),
        ({"robot": "panda", "task": "lift", "seeds": "train"}, UnknownNameError),
    ],
)
def test_what_there_is_not_is_refused(options: dict[str, str], error: type[LfrError]) -> None:
    with pytest.raises(error):
        LfrEnv(**options)
