"""An episode read back from its recording."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lfr.data.episode import ACTION, REWARD, STATE, Episode
from lfr.errors import DataError
from lfr.view.motion import poses_of_observations, poses_of_states

from . import rrd
from .conftest import FRAMES, INTRINSICS, Recorded


def test_transforms_are_mujocos_body_poses(recorded: Recorded, shown: Path) -> None:
    entities = rrd.read(shown)
    for body in ("robot0_link7", "gripper0_right_leftfinger", "cube_main"):
        transform = entities[f"/world/{body}"]
        frames, translations = transform["Transform3D:translation"]
        assert frames is not None
        np.testing.assert_array_equal(frames, np.arange(FRAMES + 1))
        expected = recorded.poses[body]
        np.testing.assert_allclose(np.array(translations)[:, 0], expected[:, :3], atol=1e-6)
        xyzw = np.array(transform["Transform3D:quaternion"][1])[:, 0]
        np.testing.assert_allclose(xyzw, expected[:, [4, 5, 6, 3]], atol=1e-6)


def test_series_are_the_recorded_features(recorded: Recorded, shown: Path) -> None:
    features = recorded.episode.features
    translation = rrd.rows(shown, "/action/translation", "Scalars:scalars")
    np.testing.assert_array_equal(translation, features[ACTION][:, :3])
    np.testing.assert_array_equal(rrd.rows(shown, "/reward", "Scalars:scalars"), features[REWARD])
    eef = rrd.rows(shown, "/observation/eef_pos", "Scalars:scalars")
    np.testing.assert_array_equal(eef, features[STATE][:, :3])
    entities = rrd.read(shown)
    names = entities["/action/rotation"]["SeriesLines:names"][1][0]
    assert names == ["drx", "dry", "drz"]
    words = [state[0] for state in entities["/state/success"]["StateChange:state"][1]]
    assert words == ["not yet"] * 9 + ["success"] * 3
    assert len(entities["/camera/agentview"]["EncodedImage:blob"][1]) == FRAMES


def test_a_frustum_stands_where_its_camera_is(recorded: Recorded, shown: Path) -> None:
    entities = rrd.read(shown)
    frames, translations = entities["/frustum/wrist"]["Transform3D:translation"]
    np.testing.assert_array_equal(frames, np.arange(FRAMES + 1))
    hand = recorded.poses["robot0_right_hand"][:, :3]
    np.testing.assert_allclose(np.array(translations)[:, 0], hand, atol=1e-6)
    assert len(entities["/frustum/agentview"]["Transform3D:translation"][1]) == 1
    for camera in ("agentview", "wrist"):
        pinhole = entities[f"/frustum/{camera}"]
        projection = np.array(pinhole["Pinhole:image_from_camera"][1]).reshape(3, 3).T
        np.testing.assert_allclose(projection, INTRINSICS)
        assert np.ravel(pinhole["Pinhole:resolution"][1]).tolist() == [64, 64]
        assert len(entities[f"/camera/{camera}"]["EncodedImage:blob"][1]) == FRAMES


def test_the_path_ends_where_the_hand_is(recorded: Recorded, shown: Path) -> None:
    from lfr.view.path import end_effector_path

    path = end_effector_path(recorded.episode, recorded.poses)
    assert path is not None
    hand = recorded.poses["gripper0_right_eef"][:FRAMES, :3]
    np.testing.assert_allclose(path, hand, atol=3e-3)  # the site lies in the body; 2 ms of lag
    assert any(entity.startswith("/path/gripper_") for entity in rrd.read(shown))


def test_both_timelines_and_a_blueprint(shown: Path) -> None:
    from rerun.experimental import RrdReader

    reader = RrdReader(shown)
    chunks = [c for c in reader.stream().to_chunks() if c.entity_path == "/reward"]
    timelines = {name for chunk in chunks for name in chunk.timeline_names}
    assert timelines == {"time", "frame"}
    assert len(reader.blueprints()) == 1


def test_poses_of_states_equal_the_logged_ones(recorded: Recorded) -> None:
    poses = poses_of_states(recorded.episode)
    for body in ("robot0_link7", "gripper0_right_rightfinger", "cube_main"):
        # logged poses lag their state by one substep of 2 ms, as MuJoCo's own xpos does
        np.testing.assert_allclose(poses[body], recorded.poses[body], atol=5e-3)


def test_poses_of_observations_come_near_those_of_states(recorded: Recorded) -> None:
    exact, near = poses_of_states(recorded.episode), poses_of_observations(recorded.episode)
    # a moving hand's fingers are up to 1 mm from where two symmetric ones would be
    for body, metres in (("robot0_link7", 1e-5), ("gripper0_right_leftfinger", 2e-3)):
        found, expected = near[body][:, :3], exact[body][:FRAMES, :3]
        np.testing.assert_allclose(found, expected, atol=metres)
    cube, expected = near["cube_main"], exact["cube_main"][:FRAMES]
    np.testing.assert_allclose(cube[:, :3], expected[:, :3], atol=1e-5)
    cosine = np.abs(np.sum(cube[:, 3:] * expected[:, 3:], axis=1))
    assert np.abs(cosine - cosine[0]).max() < 1e-5  # the same, up to a quarter turn


@pytest.mark.parametrize("name", ["observation.joint_position", "observation.state"])
def test_a_missing_column_is_named(recorded: Recorded, name: str) -> None:
    features = {k: v for k, v in recorded.episode.features.items() if k != name}
    episode: Episode = replace(recorded.episode, features=features)
    with pytest.raises(DataError, match=name):
        poses_of_observations(episode)
