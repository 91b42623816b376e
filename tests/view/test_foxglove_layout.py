"""The committed layout for Foxglove: current, whole, and of topics and fields that a log has."""

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import foxglove.messages
import numpy as np
import pytest
from mcap.reader import make_reader

from lfr.data.episode import EpisodeInfo
from lfr.data.log import EpisodeLog, Frame
from lfr.data.messages import CameraModel, identifier, message_class
from lfr.embodiments import Embodiment, embodiment
from lfr.spaces import ROBOT_STATE
from lfr.tasks import task
from lfr.view.foxglove_layout import FILE, foxglove_layout
from lfr.view.log_layout import DEFAULT, EYE
from tests.data import made_up

LENGTH = 4
Log = dict[str, list[tuple[str, Any]]]
"""Topic -> schema's name and message, in the order of their times."""


@pytest.fixture(scope="module", params=["panda", "sawyer-joint_position"])
def body(request: pytest.FixtureRequest) -> Embodiment:
    return embodiment(request.param)


@pytest.fixture(scope="module")
def layout(body: Embodiment) -> dict[str, Any]:
    """The committed one, or that of another embodiment."""
    return json.loads(FILE.read_text()) if body.name == DEFAULT else foxglove_layout(body)


@pytest.fixture(scope="module")
def frames(body: Embodiment) -> list[Frame]:
    rng, size = np.random.default_rng(1), task("lift").observation.size
    plain = made_up.frames(seed=1, length=LENGTH, image_size=32, robot=body.name)
    return [replace(frame, observation=rng.normal(size=size)) for frame in plain]


@pytest.fixture(scope="module")
def log(body: Embodiment, frames: list[Frame], tmp_path_factory: pytest.TempPathFactory) -> Log:
    """A log with the state of every arm, read with the schemas that it carries itself."""
    info = EpisodeInfo.of(body, task("lift"), 1)
    camera = CameraModel(32, 32, np.eye(3), np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
    path = tmp_path_factory.mktemp("foxglove") / "episode-000000.mcap"
    with EpisodeLog(path, info, {"agentview": camera}) as writer:
        for frame in frames:
            writer.frame(frame)
        writer.finish(np.arange(30.0), frames[-1].body_poses)
    found: Log = {}
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            assert schema is not None
            decoded = message_class(schema.name, schema.data).FromString(message.data)
            found.setdefault(channel.topic, []).append((schema.name, decoded))
    return found


def value_at(log: Log, path: str, number: int = 0) -> Any:
    """What a message path selects in one message of its topic.

    Foxglove's grammar (docs.foxglove.dev, message path syntax) without slices and filters.
    """
    parts = re.fullmatch(r"(?P<topic>(?:/\w+)+)(?P<fields>(?:\.\w+(?:\[\d+\])?)*)", path)
    assert parts is not None, path
    _, value = log[parts["topic"]][number]
    for name, index in re.findall(r"\.(\w+)(?:\[(\d+)\])?", parts["fields"]):
        value = getattr(value, name)
        value = value[int(index)] if index else value
    return value


def panels(layout: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    return [options for name, options in layout["configById"].items() if name.split("!")[0] == kind]


def leaves(place: str | dict[str, Any]) -> Iterator[str]:
    if isinstance(place, str):
        yield place
        return
    assert place["direction"] in ("row", "column")
    assert 5 < place["splitPercentage"] < 95
    yield from leaves(place["first"])
    yield from leaves(place["second"])


def test_the_committed_file_is_current() -> None:
    expected = foxglove_layout(embodiment(DEFAULT))
    assert json.loads(FILE.read_text()) == expected, "run `python -m lfr.view.foxglove_layout`"


@pytest.mark.parametrize("cameras", [(), ("agentview", "wrist", "sideview")])
def test_the_layout_of_logs_with_other_cameras(cameras: tuple[str, ...]) -> None:
    layout = foxglove_layout(embodiment(DEFAULT), cameras)
    assert sorted(leaves(layout["layout"])) == sorted(layout["configById"])
    topics = [image["imageMode"]["imageTopic"] for image in panels(layout, "Image")]
    assert topics == [f"/camera/{camera}" for camera in cameras]
    (bodies,) = panels(layout, "3D")
    assert list(bodies.get("topics", {})) == [f"{topic}/calibration" for topic in topics]


def test_every_panel_has_one_place_and_a_title(layout: dict[str, Any]) -> None:
    assert sorted(leaves(layout["layout"])) == sorted(layout["configById"])
    titles = [options["foxglovePanelTitle"] for options in layout["configById"].values()]
    assert len(set(titles)) == len(titles)
    for kind in ("3D", "Image", "RawMessages", "Plot"):
        assert panels(layout, kind), kind


def test_every_plotted_path_is_a_number_of_a_log(
    body: Embodiment, layout: dict[str, Any], log: Log, frames: list[Frame]
) -> None:
    paths = [each["value"] for plot in panels(layout, "Plot") for each in plot["paths"]]
    assert len(set(paths)) == len(paths)
    for path in paths:
        for number in range(LENGTH):
            assert isinstance(value_at(log, path, number), float), path

    last = frames[-1]
    logged = {
        **{
            f"/action.{identifier(name)}": value
            for name, value in zip(body.action.names, last.action, strict=True)
        },
        **{f"/joint_states.joints[{k}].position": last.joint_position[k] for k in range(7)},
        **{
            f"/observation.{identifier(name)}": value
            for name, value in zip(ROBOT_STATE.names, last.observation, strict=False)
        },
        "/reward.reward": last.reward,
        "/success.success": 1.0,
    }
    assert {path: value_at(log, path, LENGTH - 1) for path in paths} == {
        path: logged[path] for path in paths
    }
    shown = {path.split(".")[0] for path in paths}
    assert shown == {"/action", "/observation", "/reward", "/success", "/joint_states"}


def test_what_is_drawn_has_schemas_that_foxglove_draws(layout: dict[str, Any], log: Log) -> None:
    schemas = {topic: name for topic, each in log.items() for name, _ in each}
    for name in schemas.values():
        assert name.startswith("lfr.") or hasattr(foxglove.messages, name.split(".")[1]), name
    assert schemas["/tf"] == "foxglove.FrameTransforms"
    assert schemas["/joint_states"] == "foxglove.JointStates"
    (image,), (bodies,) = panels(layout, "Image"), panels(layout, "3D")
    assert schemas[image["imageMode"]["imageTopic"]] == "foxglove.CompressedImage"
    assert [schemas[topic] for topic in bodies["topics"]] == ["foxglove.CameraCalibration"]
    assert all(raw["topicPath"] in schemas for raw in panels(layout, "RawMessages"))


def test_it_is_placed_in_a_frame_of_a_log(layout: dict[str, Any], log: Log) -> None:
    poses = [pose for _, message in log["/tf"] for pose in message.transforms]
    frames = {frame for pose in poses for frame in (pose.parent_frame_id, pose.child_frame_id)}
    (bodies,) = panels(layout, "3D")
    named = {bodies["followTf"], *(layer["frameId"] for layer in bodies["layers"].values())}
    named |= {key.removeprefix("frame:") for key in bodies["transforms"]}
    assert named <= frames
    assert {message.frame_id for _, message in log["/camera/agentview"]} <= frames


def test_it_looks_from_where_the_layout_for_rerun_looks(layout: dict[str, Any]) -> None:
    (bodies,) = panels(layout, "3D")
    state = bodies["cameraState"]
    # As Foxglove Studio's CameraStateSettings places its camera: spherical coordinates about y,
    # the azimuth reversed, then a quarter of a turn about x.
    phi, theta = np.radians(state["phi"]), -np.radians(state["thetaOffset"])
    spherical = np.array([np.sin(phi) * np.sin(theta), np.cos(phi), np.sin(phi) * np.cos(theta)])
    about_x = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    eye = state["targetOffset"] + state["distance"] * about_x @ spherical
    np.testing.assert_allclose(eye, EYE.position, atol=2e-3)
    np.testing.assert_allclose(state["targetOffset"], EYE.target)
