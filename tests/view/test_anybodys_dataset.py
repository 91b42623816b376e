"""Datasets that are not this project's: written by LeRobot itself, or imported from robomimic."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from PIL import Image
from rerun.experimental import RrdReader

from lfr.cli import main
from lfr.data.episode import ACTION, JOINT_POSITION, STATE, EpisodeInfo, features
from lfr.data.log import EpisodeLog, Frame
from lfr.spaces import joint_motion
from lfr.view.dataset import _labels, read_episode
from lfr.view.motion import poses_of_states
from lfr.view.path import end_effector_dimensions

from ..data.made_up import picture
from ..importing import made_up as robomimic
from . import rrd
from .conftest import FRAMES, Recorded

MOTORS = [f"{motor}.pos" for motor in ("shoulder_pan", "elbow_flex", "wrist_roll", "gripper")]
LENGTHS = (8, 6)
HAND = "gripper0_right_eef"


@dataclass(frozen=True)
class Written:
    """A dataset's folder, and the frames that were handed to LeRobot, by episode."""

    path: Path
    frames: list[list[dict[str, np.ndarray]]]

    def column(self, key: str, episode: int = 0) -> np.ndarray:
        return np.stack([frame[key] for frame in self.frames[episode]])


def write(
    root: Path, robot: str | None, fps: int, features: dict[str, Any], episodes: list[Any]
) -> Written:
    """Record episodes, each a list of frames, with LeRobot's own writer."""
    from lerobot.datasets import LeRobotDataset

    videos = any(feature["dtype"] == "video" for feature in features.values())
    recorded = LeRobotDataset.create(
        "theirs/made-up", fps, features, root=root, robot_type=robot, use_videos=videos
    )
    for frames in episodes:
        for frame in frames:
            recorded.add_frame({**frame, "task": "Reach."})
        recorded.save_episode()
    recorded.finalize()
    return Written(root, episodes)


def vector(size: int, names: object = None) -> dict[str, Any]:
    return {"dtype": "float32", "shape": (size,), "names": names}


def pictures(dtype: str) -> dict[str, Any]:
    return {"dtype": dtype, "shape": (64, 96, 3), "names": ["height", "width", "channels"]}


@pytest.fixture(scope="module")
def motors(tmp_path_factory: pytest.TempPathFactory) -> Written:
    """Joint angles and a camera, 30 fps; names in the two forms that datasets on the Hub have."""
    features = {
        STATE: vector(4, {"motors": MOTORS}),
        ACTION: vector(4, MOTORS),
        "observation.images.top": pictures("video"),
    }
    rng = np.random.default_rng(0)
    episodes = [
        [
            {
                STATE: rng.normal(size=4).astype(np.float32),
                ACTION: rng.normal(size=4).astype(np.float32),
                "observation.images.top": picture(episode, t, 96)[:64],
            }
            for t in range(length)
        ]
        for episode, length in enumerate(LENGTHS)
    ]
    return write(tmp_path_factory.mktemp("motors") / "so100-reach", "so100", 30, features, episodes)


@pytest.fixture(scope="module")
def pushes(tmp_path_factory: pytest.TempPathFactory) -> Written:
    """An end effector without a robot, unnamed actions, an effort beside, pictures in the rows."""
    features = {
        STATE: vector(4, ["ee.x", "ee.y", "ee.z", "force (N)"]),
        "observation.effort": vector(2, ["ee.x", "ee.y"]),
        ACTION: vector(2),
        "observation.image": pictures("image"),
    }
    rng = np.random.default_rng(1)
    frames = [
        {
            STATE: rng.normal(size=4).astype(np.float32),
            "observation.effort": rng.normal(size=2).astype(np.float32),
            ACTION: rng.normal(size=2).astype(np.float32),
            "observation.image": picture(0, t, 96)[:64],
        }
        for t in range(5)
    ]
    return write(tmp_path_factory.mktemp("pushes") / "pushes", None, 10, features, [frames])


@pytest.fixture(scope="module")
def pours(recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Written:
    """An arm that is known, at a task that is not: the joints of the recorded episode."""
    features = {JOINT_POSITION: vector(7), ACTION: vector(3, ["x", "y", "z"])}
    joints = recorded.episode.features[JOINT_POSITION]
    frames = [{JOINT_POSITION: row, ACTION: np.zeros(3, np.float32)} for row in joints]
    return write(tmp_path_factory.mktemp("pours") / "pours", "panda", 20, features, [frames])


def opened(path: Path, out: Path) -> Mapping[str, Mapping[str, rrd.Column]]:
    assert main(["view", str(path), "--save", str(out)]) == 0
    return rrd.read(out)


def names_of(entities: Mapping[str, Mapping[str, rrd.Column]], entity: str) -> list[str]:
    return entities[entity]["SeriesLines:names"][1][0]


def seconds(file: Path, entity: str) -> np.ndarray:
    (chunk,) = (
        chunk
        for chunk in RrdReader(file).stream().to_chunks()
        if chunk.entity_path == entity and "time" in chunk.timeline_names
    )
    times = chunk.to_record_batch().column("time")
    return times.cast(pa.int64()).to_numpy(zero_copy_only=False) / 1e9


def brightness(files: list[Any]) -> list[float]:
    """Red of each picture, which tells the frames apart."""
    blobs = (np.asarray(file, np.uint8).tobytes() for file in files)
    return [np.asarray(Image.open(io.BytesIO(blob)))[..., 0].mean() for blob in blobs]


def test_motors_and_a_camera(motors: Written, tmp_path: Path) -> None:
    file = tmp_path / "motors.rrd"
    entities = opened(motors.path, file)
    for entity, key in (("/observation/state", STATE), ("/action/action", ACTION)):
        np.testing.assert_array_equal(rrd.rows(file, entity, "Scalars:scalars"), motors.column(key))
        assert names_of(entities, entity) == MOTORS
    np.testing.assert_allclose(seconds(file, "/action/action"), np.arange(8) / 30, atol=1e-8)
    np.testing.assert_allclose(seconds(file, "/camera/top"), np.arange(8) / 30, atol=1e-8)
    frames = entities["/camera/top"]["EncodedImage:blob"][1]
    expected = motors.column("observation.images.top")[..., 0].mean(axis=(1, 2))
    np.testing.assert_allclose(brightness([f[0] for f in frames]), expected, atol=4)
    shown = {path.split("/")[1] for path in entities}
    assert not shown & {"path", "gripper", "reward", "state", "joints"}
    assert not any(path.startswith("/world/") for path in entities)
    name = entities["/__properties"]["RecordingInfo:name"][1][0][0]
    assert name == "0 · so100 · Reach."  # neither a seed nor an outcome is said


def test_the_path_of_an_end_effector_without_a_robot(pushes: Written, tmp_path: Path) -> None:
    file = tmp_path / "pushes.rrd"
    entities = opened(pushes.path, file)
    states = pushes.column(STATE)
    (strips,) = entities["/path/end_effector"]["LineStrips3D:strips"][1]
    np.testing.assert_allclose(np.array(strips[0]), states[:, :3], atol=1e-6)
    force = rrd.rows(file, "/observation/force__N_", "Scalars:scalars")
    np.testing.assert_array_equal(force, states[:, 3])
    effort = rrd.rows(file, "/observation/effort_ee", "Scalars:scalars")  # "ee" is the state's
    np.testing.assert_array_equal(effort, pushes.column("observation.effort"))
    assert names_of(entities, "/action/action") == ["0", "1"]
    expected = pushes.column("observation.image")[..., 0].mean(axis=(1, 2))
    frames = entities["/camera/image"]["EncodedImage:blob"][1]
    np.testing.assert_allclose(brightness([f[0] for f in frames]), expected, atol=4)


def test_a_known_arm_at_an_unknown_task_stands_alone(
    pours: Written, recorded: Recorded, tmp_path: Path
) -> None:
    """Its base at the origin, its bodies where the simulator had them from the base."""
    entities = opened(pours.path, tmp_path / "pours.rrd")
    base = recorded.poses["robot0_base"][0, :3]
    exact = poses_of_states(recorded.episode)
    for body in ("robot0_link0", "robot0_link4", "robot0_link7"):
        assert f"/world/{body}/mesh" in entities
        frames, places = entities[f"/world/{body}"]["Transform3D:translation"]
        assert frames is not None
        expected = exact[body][:FRAMES, :3] - base
        np.testing.assert_allclose(np.array(places)[:, 0], expected, atol=1e-5)
    (strips,) = entities["/path/end_effector"]["LineStrips3D:strips"][1]
    np.testing.assert_allclose(np.array(strips[0]), exact[HAND][:FRAMES, :3] - base, atol=1e-5)
    assert not {path.split("/")[2] for path in entities if path.startswith("/world/")} & {
        "table", "cube_main"
    }  # fmt: skip


def test_what_is_imported_from_robomimic(recorded: Recorded, tmp_path: Path) -> None:
    """Arm and table of Lift; the cube's place is in the observation, under a name unknown here."""
    exact = poses_of_states(recorded.episode)
    demo = robomimic.demo(0, FRAMES)
    demo["obs/robot0_joint_pos"] = recorded.episode.features[JOINT_POSITION].astype(np.float64)
    demo["obs/robot0_gripper_qpos"] = recorded.episode.simulator_state[:FRAMES, 7:9]
    file = robomimic.write(tmp_path / "low_dim.hdf5", {"demo_0": demo}, masks={})
    out = tmp_path / "robomimic-lift"
    assert main(["import", str(file), "--to", str(out)]) == 0
    entities = opened(out, tmp_path / "lift.rrd")
    for body in ("robot0_link7", "gripper0_right_leftfinger", "gripper0_right_rightfinger"):
        places = np.array(entities[f"/world/{body}"]["Transform3D:translation"][1])[:, 0]
        np.testing.assert_allclose(places, exact[body][:FRAMES, :3], atol=1e-5)
    assert "/world/table" in entities
    assert not any(path.startswith("/world/cube_main") for path in entities)
    strips = [
        strip
        for path in ("/path/gripper_open", "/path/gripper_closing")
        for strip in entities[path]["LineStrips3D:strips"][1][0]
    ]
    points = np.array([point for strip in strips for point in strip])
    hand = exact[HAND][:FRAMES, :3]
    apart = np.linalg.norm(points[:, None] - hand[None], axis=2)
    assert apart.min(axis=0).max() < 1e-5  # each frame is on the path
    assert apart.min(axis=1).max() < 1e-5  # and nothing else
    np.testing.assert_array_equal(
        rrd.rows(tmp_path / "lift.rrd", "/observation/robot0_eef_pos", "Scalars:scalars"),
        demo["obs/robot0_eef_pos"].astype(np.float32),
    )
    assert "/gripper" not in entities  # eleven numbers are not yet an aperture and a command


def test_lists_and_several_episodes(
    motors: Written, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["view", str(motors.path), "--list", "--sort", "length", "--reverse"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].split() == ["1", "6", "0.20", "-", "-", "-"]
    assert lines[-1] == "2 episodes, 14 frames, 0 s"
    out = tmp_path / "both.rrd"
    assert main(["view", str(motors.path), "--episodes", "0,1", "--save", str(out)]) == 0
    assert len(RrdReader(out).recordings()) == 2


def test_a_log_of_an_unknown_robot(tmp_path: Path) -> None:
    """The log of docs/bring-a-dataset.md."""
    state, environment = ("hand_pos.x", "hand_pos.y"), ("cube_pos.x", "cube_pos.y")
    joints = tuple(f"joint{number}" for number in range(5))
    known = features(state, environment, joints, joint_motion(joints).names)
    info = EpisodeInfo("mine", "push", 0, "push it", known)
    log = tmp_path / "episode-000000.mcap"
    with EpisodeLog(log, info) as episode:
        for step in range(4):
            episode.frame(
                Frame(
                    observation=np.full(4, float(step)),
                    joint_position=np.zeros(5),
                    action=np.zeros(5),
                    reward=0.0,
                    success=step == 3,
                    simulator_state=np.zeros(1),
                )
            )
        episode.finish(simulator_state=np.zeros(1))
    entities = opened(log, tmp_path / "mine.rrd")
    assert names_of(entities, "/observation/hand_pos") == ["x", "y"]
    assert names_of(entities, "/action/dq") == list(joints)
    assert not any(path.startswith("/world/") for path in entities)


def test_a_dataset_says_neither_seed_nor_success(motors: Written) -> None:
    episode = read_episode(motors.path, 1)
    assert (episode.robot, episode.task, len(episode)) == ("so100", "", LENGTHS[1])
    assert sorted(episode.metadata["unsaid"]) == ["seed", "success"]


@pytest.mark.parametrize(
    ("names", "size", "expected"),
    [
        (["a", "b"], 2, ("a", "b")),
        ({"motors": ["a", "b"]}, 2, ("a", "b")),
        ({"left": ["a"], "right": ["a"]}, 2, ("left.a", "right.a")),
        ({"a": 0, "b": 1}, 2, ("a", "b")),
        (["height", "width"], 3, ("state.0", "state.1", "state.2")),
        (None, 2, ("state.0", "state.1")),
        (None, 1, ("state",)),
    ],
)
def test_names_come_in_many_forms(names: Any, size: int, expected: tuple[str, ...]) -> None:
    values = np.zeros((4, size)) if size > 1 else np.zeros(4)
    assert _labels(STATE, {"names": names}, values) == expected


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["eef_pos.x", "eef_pos.y", "eef_pos.z"], [0, 1, 2]),
        (["gripper", "robot0_eef_pos.x", "robot0_eef_pos.y", "robot0_eef_pos.z"], [1, 2, 3]),
        (["x", "y", "z", "roll", "pitch", "yaw", "pad", "gripper"], [0, 1, 2]),
        (["x", "y", "z", "tcp_x", "tcp_y", "tcp_z"], [3, 4, 5]),
        (["EE.X", "EE.Y", "EE.Z"], [0, 1, 2]),
        (["x", "y"], None),
        (["cube_pos.x", "cube_pos.y", "cube_pos.z"], None),
        (MOTORS, None),
        ([], None),
    ],
)
def test_an_end_effector_is_known_by_its_names(
    names: list[str], expected: list[int] | None
) -> None:
    assert end_effector_dimensions(names) == expected


def test_two_stand_side_by_side(pushes: Written, motors: Written, tmp_path: Path) -> None:
    out = tmp_path / "pair.rrd"
    arguments = ["view", str(pushes.path), "--side-by-side", f"{motors.path}:1", "--save", str(out)]
    assert main(arguments) == 0
    actions = rrd.rows(out, "/right/action/action", "Scalars:scalars")
    np.testing.assert_array_equal(actions, motors.column(ACTION, 1))
    assert "/left/path/end_effector" in rrd.read(out)
