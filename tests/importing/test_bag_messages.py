"""Pictures and numbers out of messages of every encoding, and what `lfr columns` proposes."""

import base64
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from mcap.writer import Writer
from mcap_protobuf.writer import Writer as ProtobufWriter
from PIL import Image
from ruamel.yaml import YAML

from lfr.artifacts import read_json
from lfr.cli import main
from lfr.data.messages import message_class, record
from lfr.errors import DataError, ParameterError
from lfr.importing.bag.decoding import MessageError
from lfr.importing.bag.files import find_bags
from lfr.importing.bag.mapping import BagMapping
from lfr.importing.bag.pictures import picture
from lfr.importing.bag.reading import read_messages
from lfr.importing.bag.values import number_paths, numbers
from lfr.records import from_mapping

from . import ros2
from .ros2 import DEFINITIONS, Said

BAG = Path(__file__).parent / "rosbags_take"  # `rosbags_take.py` wrote it


def decoded(tmp_path: Path, *messages: Said) -> list[Any]:
    bag = ros2.write(tmp_path / "one.mcap", messages)
    (found,) = find_bags([bag])
    return [source.decode(message.data) for source, message in read_messages(found)]


RGB = np.random.default_rng(0).integers(0, 255, (40, 48, 3), dtype=np.uint8)
ALPHA = np.full((40, 48, 1), 7, np.uint8)


@pytest.mark.parametrize("padding", [0, 5])
@pytest.mark.parametrize(
    ("encoding", "array", "expected"),
    [
        ("rgb8", RGB, RGB),
        ("bgr8", RGB[..., ::-1], RGB),
        ("rgba8", np.concatenate([RGB, ALPHA], axis=2), RGB),
        ("bgra8", np.concatenate([RGB[..., ::-1], ALPHA], axis=2), RGB),
        ("mono8", RGB[..., 0], np.repeat(RGB[..., :1], 3, axis=2)),
        ("8UC1", RGB[..., 0], np.repeat(RGB[..., :1], 3, axis=2)),
    ],
)
def test_raw_pictures(
    tmp_path: Path, encoding: str, array: np.ndarray, expected: np.ndarray, padding: int
) -> None:
    said = ros2.raw("/image", 0, np.ascontiguousarray(array), encoding, padding=padding)
    (message,) = decoded(tmp_path, said)
    np.testing.assert_array_equal(np.asarray(picture(message)), expected)


def test_compressed_pictures(tmp_path: Path) -> None:
    said = ros2.compressed("/image", 0, RGB, format="png")
    said[3]["format"] = "bgr8; png compressed bgr8"  # pyright: ignore[reportIndexIssue]
    (message,) = decoded(tmp_path, said)
    np.testing.assert_array_equal(np.asarray(picture(message)), RGB)


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"encoding": "16UC1"}, "16UC1: a picture of depth"),
        ({"encoding": "32FC1"}, "32FC1: a picture of depth"),
        ({"encoding": "bayer_rggb8"}, "pictures in bayer_rggb8; supported: rgb8, bgr8"),
        ({"encoding": "rgb8", "data": b"123"}, "3 bytes for 48 x 40 pixels in rgb8"),
        ({"encoding": "rgb8", "step": 10}, "10 bytes a row"),
        ({"encoding": "rgb8", "height": 2**31}, "bytes for 48 x 2147483648"),
    ],
)
def test_pictures_that_are_none(tmp_path: Path, changes: dict[str, Any], error: str) -> None:
    time, topic, type, content = ros2.raw("/image", 0, RGB, "rgb8")
    (message,) = decoded(tmp_path, (time, topic, type, {**content, **changes}))
    with pytest.raises(MessageError, match=error):
        picture(message)


def test_depth_in_a_png_is_no_picture(tmp_path: Path) -> None:
    buffer = io.BytesIO()
    Image.fromarray(np.full((40, 48), 1500, np.uint16)).save(buffer, "PNG")
    for format, error in (("png", "mode I;16"), ("16UC1; compressedDepth png", "depth")):
        content = {"header": ros2.header(0), "format": format, "data": buffer.getvalue()}
        said = (0.0, "/depth", "sensor_msgs/msg/CompressedImage", content)
        (message,) = decoded(tmp_path, said)
        with pytest.raises(MessageError, match=error):
            picture(message)


def test_numbers_of_every_kind(tmp_path: Path) -> None:
    point = {"positions": [1.0, 2.0], "time_from_start": {"sec": 3, "nanosec": 4}}
    pose = {"position": {"x": 1, "y": 2, "z": 3}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}
    gripper = {"width": 0.5, "fingers": [{"force": 1.5}, {"force": 2.5, "touches": True}],
               "model": "two"}  # fmt: skip
    array = {"layout": {"dim": [], "data_offset": 9}, "data": [1.0, 2.0]}
    joints = ros2.joints("/j", 0, ["a", "b"], [1.0, 2.0], effort=[3.0, 4.0])
    cases: list[tuple[str, Any, dict[str, tuple[Any, list[float]]]]] = [
        (joints[2], joints[3], {"position": (("a", "b"), [1, 2]), "effort": (("a", "b"), [3, 4])}),
        ("geometry_msgs/msg/PoseStamped", {"header": ros2.header(0), "pose": pose}, {
            "pose": ((*(f"position.{a}" for a in "xyz"), *(f"orientation.{a}" for a in "xyzw")),
                     [1, 2, 3, 0, 0, 0, 1])}),
        ("geometry_msgs/msg/Twist", {"linear": {"x": 1}}, {
            "": (tuple(f"{v}.{a}" for v in ("linear", "angular") for a in "xyz"),
                 [1, 0, 0, 0, 0, 0])}),
        ("trajectory_msgs/msg/JointTrajectory",
         {"header": ros2.header(0), "joint_names": ["a", "b"], "points": [point]},
         {"points[0].positions": (("a", "b"), [1, 2])}),
        ("std_msgs/msg/Float64MultiArray", array, {"data": (None, [1, 2])}),
        ("std_msgs/msg/Bool", {"data": True}, {"data": (None, [1])}),
        ("std_msgs/msg/String", {"data": "words"}, {}),
        ("my_gripper_msgs/msg/GripperStatus", gripper, {
            "width": (None, [0.5]), "fingers[0]": (("force", "touches"), [1.5, 0])}),
    ]  # fmt: skip
    messages = decoded(tmp_path, *((0.0, f"/{i}", t, c) for i, (t, c, _) in enumerate(cases)))
    for message, (type, _, expected) in zip(messages, cases, strict=True):
        assert {path: numbers(message, path) for path in number_paths(message)} == expected, type
    assert numbers(messages[-1], "fingers[1].force") == (None, [2.5])
    assert numbers(messages[1], "") == (
        tuple(f"pose.{name}" for name in cases[1][2]["pose"][0]), cases[1][2]["pose"][1],
    )  # fmt: skip


def test_the_proposal_is_a_mapping_that_works(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    times = (np.arange(60) / 30).tolist()
    messages = [m for t in times for m in (
        ros2.joints("/joint_states", t, ["a", "b"], [t, -t]),
        ros2.joints("/joint_states", t, ["finger"], [5 * t]),
        (t, "/arm/commands", "std_msgs/msg/Float64MultiArray",
         {"layout": {"dim": [], "data_offset": 0}, "data": [t, t]}),
        (t, "/wrench", "geometry_msgs/msg/WrenchStamped", {"header": ros2.header(t)}),
        ros2.raw("/camera/wrist/image_raw", t, RGB, "bgr8"),
        ros2.raw("/camera/depth", t, RGB[..., :2], "16UC1"),
    )]  # fmt: skip
    bag = ros2.write(tmp_path / "take.mcap", messages, chunk_size=2**20)
    assert main(["columns", str(bag)]) == 0
    printed = capsys.readouterr().out
    assert "# /wrench (geometry_msgs/msg/WrenchStamped): 60 messages, 30.0 Hz, header" in printed
    assert '# - {topic: /wrench, field: wrench, names: ["force.x"' in printed
    assert "no feature: 16UC1: a picture of depth" in printed
    mapping = YAML(typ="safe").load(printed)
    assert mapping["fps"] == 30
    assert [part.get("names") for part in mapping["features"]["observation.state"]] == [
        ["a", "b"], ["finger"],
    ]  # fmt: skip
    assert mapping["features"]["observation.images.wrist"] == {"topic": "/camera/wrist/image_raw"}
    assert mapping["features"]["action"] == [{"topic": "/arm/commands", "field": "data"}]
    (tmp_path / "map.yaml").write_text(printed)
    command = ["import", str(bag), "--mapping", str(tmp_path / "map.yaml"), "--to"]
    assert main([*command, str(tmp_path / "out")]) == 2
    assert "task is empty; say in words what is done" in capsys.readouterr().err
    (tmp_path / "map.yaml").write_text(printed.replace('task: ""', "task: push"))
    assert main([*command, str(tmp_path / "out")]) == 0
    assert pq.read_table(tmp_path / "out/data").num_rows == 60


def import_(tmp_path: Path, bag: Path, mapping: dict[str, Any]) -> Path:
    YAML(typ="safe").dump(mapping, tmp_path / "map.yaml")
    out = tmp_path / "out"
    assert (
        main(["import", str(bag), "--mapping", str(tmp_path / "map.yaml"), "--to", str(out)]) == 0
    )
    return out


def test_a_bag_by_rosbags(tmp_path: Path) -> None:
    """A folder that Ternaris' rosbags wrote: a writer, an encoder and a layout of others."""
    features = {
        "observation.state": {"topic": "/joint_states", "field": "position"},
        "observation.images.top": {"topic": "/top/image_raw/compressed"},
        "action": {"topic": "/gripper", "names": ["gripper"]},
    }
    out = import_(tmp_path, BAG, {"fps": 10, "task": "wave", "features": features})
    table = pq.read_table(out / "data")
    times = np.arange(10) / 10
    state = np.array(table["observation.state"].to_pylist())
    np.testing.assert_allclose(state, np.stack([times, -times], axis=1), atol=1e-6)
    np.testing.assert_allclose(table["action"].to_pylist(), 2 * times, atol=1e-6)


def test_messages_in_json(tmp_path: Path) -> None:
    buffer = io.BytesIO()
    Image.fromarray(RGB).save(buffer, "PNG")
    with (tmp_path / "json.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("State", "jsonschema", b'{"type": "object"}')
        state = writer.register_channel("/state", "json", schema)
        camera = writer.register_channel("/camera", "json", 0)
        for step in range(20):
            time = ros2.ns(step / 10)
            stamp = {"sec": time // ros2.SECOND, "nsec": time % ros2.SECOND}
            content = {"timestamp": stamp, "q": [step, -step], "gripper": {"width": step / 2}}
            image = {"timestamp": stamp, "format": "png",
                     "data": base64.b64encode(buffer.getvalue()).decode()}  # fmt: skip
            late = time + ros2.SECOND // 3
            writer.add_message(state, late, json.dumps(content).encode(), late)
            writer.add_message(camera, late, json.dumps(image).encode(), late)
        writer.finish()
    features = {
        "observation.state": [{"topic": "/state", "field": "q"},
                              {"topic": "/state", "field": "gripper.width"}],
        "observation.images.a": {"topic": "/camera"},
        "action": {"next": "observation.state", "names": ["q.1"]},
    }  # fmt: skip
    out = import_(tmp_path, tmp_path / "json.mcap", {"fps": 10, "task": "x", "features": features})
    table = pq.read_table(out / "data")
    steps = np.arange(19)
    expected = np.stack([steps, -steps, steps / 2], axis=1)
    np.testing.assert_array_equal(np.array(table["observation.state"].to_pylist()), expected)
    np.testing.assert_array_equal(np.array(table["action"].to_pylist()), -(steps + 1.0))
    names = read_json(out / "meta/info.json")["features"]["observation.state"]["names"]
    assert names == ["q.0", "q.1", "width"]
    assert read_json(out / "meta/source.json")["time"] == "header"


def test_messages_in_protobuf(tmp_path: Path) -> None:
    schema = record("Hand", ("x", "y", "aperture"))
    hand = message_class(schema.name, schema.data)
    with (tmp_path / "protobuf.mcap").open("wb") as stream, ProtobufWriter(stream) as writer:
        for step in range(20):
            content = hand(x=step, y=-step, aperture=0.5)
            writer.write_message("/hand", content, ros2.ns(step / 10), ros2.ns(step / 10))
    features = {
        "observation.state": {"topic": "/hand", "names": ["aperture", "x"]},
        "action": {"next": "observation.state"},
    }
    mapping = {"fps": 10, "task": "x", "features": features}
    out = import_(tmp_path, tmp_path / "protobuf.mcap", mapping)
    rows = np.array(pq.read_table(out / "data")["observation.state"].to_pylist())
    np.testing.assert_array_equal(rows, np.stack([np.full(19, 0.5), np.arange(19)], axis=1))


def test_this_projects_own_logs_have_topics(tmp_path: Path) -> None:
    """Foxglove's JointStates: a list of messages, each with the joint's name."""
    import foxglove
    from foxglove.channels import JointStatesChannel

    from lfr.data.messages import joint_states

    with foxglove.open_mcap(str(tmp_path / "own.mcap")):
        channel = JointStatesChannel("/joints")
        for step in range(20):
            time = ros2.ns(step / 10)
            channel.log(joint_states(["a", "b"], [step, 2 * step], None, time), log_time=time)
    features = {
        "observation.state": {"topic": "/joints", "field": "joints.position", "names": ["b", "a"]},
        "action": {"next": "observation.state"},
    }
    mapping = {"fps": 10, "task": "x", "features": features}
    out = import_(tmp_path, tmp_path / "own.mcap", mapping)
    rows = np.array(pq.read_table(out / "data")["observation.state"].to_pylist())
    np.testing.assert_array_equal(rows, np.stack([2 * np.arange(19), np.arange(19)], axis=1))


@pytest.mark.parametrize(
    ("encoding", "schema", "data", "error"),
    [
        ("cdr", ("a/msg/B", "ros2idl", b"module a {};"), b"\0\1\0\0", "cdr with schema ros2idl"),
        ("cdr", ("a/msg/B", "ros2msg", b""), b"\0\1\0\0", r"holds no numbers|no field|cannot"),
        ("cdr", ("a/msg/B", "ros2msg", b"no schema at all"), b"\0\1\0\0", "cannot be read"),
        ("cdr", ("a/msg/B", "ros2msg", b"float64[] x"), b"\0\1\0\0\xff\xff\xff\xff",
         "do not decode"),
        ("cdr", ("a/msg/B", "ros2msg", b"float64 x"), b"\0\7\0\0" + bytes(8), "not XCDR1"),
        ("ros1", ("a/B", "ros1msg", b"float64 x"), bytes(8), "messages in ros1"),
        ("", ("", "", b""), b"", "messages in no encoding"),
        ("json", ("A", "jsonschema", b"{}"), b"{'x'}", "do not decode"),
        ("protobuf", ("A", "protobuf", b"\xff\xff"), b"", "cannot be read"),
    ],
)  # fmt: skip
def test_messages_that_cannot_be_read(
    tmp_path: Path, encoding: str, schema: tuple[str, str, bytes], data: bytes, error: str
) -> None:
    with (tmp_path / "odd.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        channel = writer.register_channel("/odd", encoding, writer.register_schema(*schema))
        writer.add_message(channel, ros2.START, data, ros2.START)
        writer.finish()
    features = {"observation.state": {"topic": "/odd"}, "action": {"next": "observation.state"}}
    YAML(typ="safe").dump({"fps": 10, "task": "x", "features": features}, tmp_path / "map.yaml")
    from lfr.importing.bag.dataset import import_bags
    from lfr.importing.bag.mapping import read_mapping

    with pytest.raises(DataError, match=error):
        import_bags([tmp_path / "odd.mcap"], tmp_path / "out", read_mapping(tmp_path / "map.yaml"))
    assert main(["columns", str(tmp_path / "odd.mcap")]) == 0


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"fpz": 3}, r"unknown parameter 'fpz'; valid: fps, features, task"),
        ({"fps": 0}, "fps is 1 to 1000, found 0"),
        ({"task": " "}, "task is empty"),
        ({"time": "clock"}, "found 'clock'; valid: header, log, publish"),
        ({"episodes": {"topic": "/a"}}, "topic and start belong together"),
        ({"episodes": {"gap": 1.0, "topic": "/a", "start": 1}}, "keep one"),
        ({"tolerance": float("nan")}, "seconds above 0"),
        ({"features": {"action": {"topic": "/a", "fild": "x"}}}, "valid: topic, field, names"),
        ({"features": {"action": {"topic": "/a", "field": "x..y"}}}, "no path of fields: 'x..y'"),
        ({"features": {"action": {"topic": "/a", "names": ["x", "x"]}}}, "different ones"),
        ({"features": {"action": {"next": "state"}}}, "next is 'state'; valid:"),
        ({"features": {"observation.state": {"topic": "/a"}}}, "no feature 'action'"),
        ({"features": {"action": {"topic": "/a", "method": "hold", "tolerance": 1}}}, "holds"),
        ({"features": {"action": {"topic": "/a"}, "state": {"topic": "/a"}}}, "no name of a feat"),
        ({"features": {"action": {"topic": "/a"},
                       "observation.images.a": {"topic": "/a", "field": "x"}}}, "pictures have"),
    ],
)  # fmt: skip
def test_a_wrong_mapping_is_told(changes: dict[str, Any], error: str) -> None:
    mapping = {"fps": 30, "task": "x", "features": {"action": {"topic": "/a"}}, **changes}
    with pytest.raises(ParameterError, match=error):
        from_mapping(BagMapping, mapping, "map.yaml: mapping")


def test_definitions_are_as_a_recorder_writes_them() -> None:
    assert all(text.count("MSG: ") == text.count(ros2.LINE) for text in DEFINITIONS.values())
