"""Bags written by mcap-ros2-support become datasets whose rows are the messages that were meant."""

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from mcap.writer import CompressionType
from ruamel.yaml import YAML

from lfr.artifacts import read_json
from lfr.cli import main
from lfr.curation.verify import verify_dataset
from lfr.errors import DataError
from lfr.importing.bag.dataset import Imported, import_bags
from lfr.importing.bag.mapping import read_mapping

from . import ros2
from .ros2 import Said

JOINTS = ("shoulder", "elbow", "wrist")
STATE: dict[str, Any] = {"topic": "/joint_states", "field": "position"}
CAMERA = "observation.images.front"
PICTURES = "/front/image/compressed"
MAPPING: dict[str, Any] = {
    "fps": 20,
    "task": "push the cube",
    "features": {"observation.state": STATE, "action": {"next": "observation.state"}},
}
LATE = 0.06  # s, from a picture to its recording


def position(seconds: float) -> list[float]:
    return [seconds, 10 + 2 * seconds, -seconds]


def arm(seconds: float, start: float = 0.0, rate: float = 100.0, **more: Any) -> list[Said]:
    times = start + np.arange(round(seconds * rate)) / rate
    return [ros2.joints("/joint_states", t, JOINTS, position(t), **more) for t in times.tolist()]


def camera(
    seconds: float, start: float = 0.0, rate: float = 20.0, late: float = LATE
) -> list[Said]:
    times = start + np.arange(round(seconds * rate)) / rate
    return [
        ros2.compressed(PICTURES, t, ros2.picture(round(100 * t) % 250), late=late)
        for t in times.tolist()
    ]


def with_camera(**changes: Any) -> dict[str, Any]:
    features = {**MAPPING["features"], CAMERA: {"topic": PICTURES}}
    return {**MAPPING, "features": features, **changes}


def take(
    tmp_path: Path, messages: list[Said] | Path, mapping: Mapping[str, Any], name: str = "out"
) -> Imported:
    bag = messages if isinstance(messages, Path) else ros2.write(tmp_path / "take.mcap", messages)
    file = tmp_path / "mapping.yaml"
    YAML(typ="safe").dump(dict(mapping), file)
    return import_bags([bag], tmp_path / name, read_mapping(file))


def column(dataset: Path, key: str) -> np.ndarray:
    return np.array(pq.read_table(dataset / "data")[key].to_pylist())


def lengths(dataset: Path) -> list[int]:
    return pq.read_table(dataset / "meta/episodes")["length"].to_pylist()


def test_rows_are_the_nearest_messages_by_their_own_stamps(tmp_path: Path) -> None:
    """Pictures are recorded more than a frame late; by the recorder's clock they would be off."""
    from lerobot.datasets import LeRobotDataset

    messages = ros2.in_time([*arm(2.0, start=0.003), *camera(2.0)])
    bag = ros2.write(tmp_path / "take.mcap", messages)
    YAML(typ="safe").dump(with_camera(), tmp_path / "mapping.yaml")
    arguments = ["import", str(bag), "--mapping", str(tmp_path / "mapping.yaml")]
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 0
    dataset = LeRobotDataset("lfr/out", root=tmp_path / "out", video_backend="pyav")
    stamps = 0.003 + np.arange(200) / 100
    assert dataset.num_frames == len(dataset) == 38
    for k in range(dataset.num_frames):
        row = dataset[k]
        nearest = [
            stamps[np.abs(stamps - t).argmin()] for t in (0.003 + k / 20, 0.003 + (k + 1) / 20)
        ]
        expected = [np.float32(position(t)) for t in nearest]
        np.testing.assert_allclose(row["observation.state"], expected[0], rtol=1e-6)
        np.testing.assert_allclose(row["action"], expected[1], rtol=1e-6)
        assert row["task"] == "push the cube"
        seen = row[CAMERA][0].numpy().mean() * 255
        assert abs(seen - 5 * k) < 2.5, (k, seen)
    assert not verify_dataset(tmp_path / "out").errors
    info = read_json(tmp_path / "out/meta/info.json")
    assert info["features"]["observation.state"]["names"] == list(JOINTS)
    about = read_json(tmp_path / "out/meta/source.json")
    assert about["time"] == "header"
    lag = {each["topic"]: each for each in about["lags"]}
    assert lag["/joint_states"]["longest"] == pytest.approx(0.0, abs=1e-6)
    assert lag[PICTURES]["median"] == pytest.approx(0.003, abs=1e-6)


def test_previous_never_looks_ahead_and_hold_has_no_limit(tmp_path: Path) -> None:
    gripper = [(t, "/gripper", "std_msgs/msg/Float64", {"data": t}) for t in (0.0, 0.62, 0.88)]
    features = {
        "observation.state": {**STATE, "method": "previous"},
        "action": {"topic": "/gripper", "method": "hold", "names": ["gripper"]},
    }
    # recorded when measured, half a frame after each frame
    messages = ros2.in_time([*arm(1.0, start=0.03, rate=20), *gripper])
    take(tmp_path, messages, {**MAPPING, "features": features})
    times = 0.03 + np.arange(20) / 20
    state, action = (column(tmp_path / "out", key) for key in ("observation.state", "action"))
    np.testing.assert_allclose(state[:, 0], times, rtol=1e-6)
    expected = np.select([times < 0.62, times < 0.88], [0.0, 0.62], 0.88)
    np.testing.assert_allclose(action, expected, rtol=1e-6)
    lags = {lag["topic"]: lag for lag in read_json(tmp_path / "out/meta/source.json")["lags"]}
    assert lags["/gripper"]["longest"] == pytest.approx(0.58, abs=0.011)


def test_joints_are_told_by_name(tmp_path: Path) -> None:
    """Another order in each message, a joint more, and a gripper that publishes on the topic."""
    rng = np.random.default_rng(0)
    messages: list[Said] = []
    for t in (np.arange(100) / 50).tolist():
        values = dict(zip((*JOINTS, "extra"), [*position(t), 99.0], strict=True))
        names = rng.permutation(list(values)).tolist()
        messages.append(ros2.joints("/joint_states", t, names, [values[n] for n in names]))
        messages.append(ros2.joints("/joint_states", t, ["finger"], [5 + t]))
    features = {
        "observation.state": [
            {**STATE, "names": ["wrist", "shoulder"], "prefix": "left."},
            {**STATE, "names": ["finger"]},
        ],
        "action": {"next": "observation.state", "names": ["finger"]},
    }
    take(tmp_path, messages, {**MAPPING, "features": features})
    state = column(tmp_path / "out", "observation.state")
    times = np.ceil(np.arange(len(state)) * 2.5 - 0.5) / 50  # of two as near the earlier one
    np.testing.assert_allclose(state[:, 0], -state[:, 1], atol=1e-6)
    np.testing.assert_allclose(state[:, 2], 5 + state[:, 1], atol=0.011)
    np.testing.assert_allclose(state[:, 1], times, atol=0.011)
    info = read_json(tmp_path / "out/meta/info.json")["features"]
    assert info["observation.state"]["names"] == ["left.wrist", "left.shoulder", "finger"]
    assert info["action"]["names"] == ["finger"]
    action = column(tmp_path / "out", "action")
    np.testing.assert_array_equal(action[:-1], state[1:, 2])


@pytest.mark.parametrize(
    ("part", "message"),
    [
        (
            {"topic": "/joints"},
            r"no messages on this topic.*/joints, found /joint_states \(sensor_",
        ),
        ({**STATE, "names": ["hip"]}, r"no joint hip: .*found elbow, shoulder, wrist"),
        ({**STATE, "field": "torque"}, r"no field 'torque'; there is header, name, position"),
        ({**STATE, "field": "position[7]"}, r"position\[7\]: \[7\] of 3 items"),
        ({**STATE, "field": "name"}, r"name holds 'shoulder' where a number is expected"),
        ({**STATE, "field": "velocity"}, r"velocity has 0 values for 3 names"),
    ],
)
def test_what_is_not_in_the_bag_is_told_with_what_is(
    tmp_path: Path, part: dict[str, Any], message: str
) -> None:
    features = {"observation.state": part, "action": {"next": "observation.state"}}
    with pytest.raises(DataError, match=message):
        take(tmp_path, arm(0.5), {**MAPPING, "features": features})
    assert not (tmp_path / "out").exists()


def test_joints_of_two_publishers_want_two_parts(tmp_path: Path) -> None:
    finger = [ros2.joints("/joint_states", t / 50, ["finger"], [1.0]) for t in range(50)]
    features = {**MAPPING["features"], "observation.state": {**STATE, "names": ["wrist", "finger"]}}
    with pytest.raises(DataError, match=r"make a part for each of.*\[finger\]"):
        take(tmp_path, ros2.in_time([*arm(1.0), *finger]), {**MAPPING, "features": features})


def test_an_episode_with_a_gap_is_refused_or_cut(tmp_path: Path) -> None:
    whole = [*arm(2.0), *camera(2.0)]
    gap = [said for said in whole if said[1] != PICTURES or not 0.9 < said[0] - LATE < 1.3]
    with pytest.raises(DataError, match=r"no episode that can be taken.*no message within 0.05 s"):
        take(tmp_path, ros2.in_time(gap), with_camera(), "refused")
    found = take(tmp_path, ros2.in_time(gap), with_camera(episodes={"late": "cut"}), "cut")
    # pictures at 0.90 and 1.30 reach to 0.95 and from 1.25 on; action takes a frame of each
    assert lengths(tmp_path / "cut") == [19, 14]
    assert any("cut into 2 episodes" in note and PICTURES in note for note in found.notes)
    state = column(tmp_path / "cut", "observation.state")[:, 0]
    np.testing.assert_allclose(state[[0, 18, 19]], [0.0, 0.9, 1.25], atol=0.006)


def test_a_slow_topic_is_told_with_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"speaks every 0.2 s; a larger tolerance"):
        take(tmp_path, ros2.in_time([*arm(2.0), *camera(2.0, rate=5)]), with_camera())


def test_other_episodes_go_on_when_one_is_refused(tmp_path: Path) -> None:
    messages = [*arm(1.0), *camera(1.0), *arm(1.0, start=10), *camera(0.5, start=10)]
    messages += [*camera(0.3, start=10.7), *arm(1.0, start=20), *camera(1.0, start=20)]
    mapping = with_camera(episodes={"gap": 2.0})
    found = take(tmp_path, ros2.in_time(messages), mapping)
    assert lengths(tmp_path / "out") == [19, 19]
    (refused,) = found.refused
    assert "10.000 s to" in refused
    assert f"{PICTURES} has no message" in refused
    np.testing.assert_allclose(column(tmp_path / "out", "observation.state")[19, 0], 20, atol=0.01)


def test_a_topic_marks_episodes_and_says_the_task(tmp_path: Path) -> None:
    marks = [(0.2, True), (0.3, True), (1.2, False), (1.5, True), (2.5, False), (3.0, True)]
    messages = arm(3.5)
    messages += [(t, "/recording", "std_msgs/msg/Bool", {"data": value}) for t, value in marks]
    said = [(0.1, "push"), (1.4, ""), (1.45, "pull"), (2.0, "lift")]
    messages += [(t, "/task", "std_msgs/msg/String", {"data": words}) for t, words in said]
    mapping = {
        **MAPPING,
        "task": {"topic": "/task"},
        "episodes": {"topic": "/recording", "start": True, "end": False},
    }
    found = take(tmp_path, ros2.in_time(messages), mapping)
    rows = pq.read_table(tmp_path / "out/meta/episodes").to_pylist()
    assert [row["tasks"] for row in rows] == [["push"], ["pull"]]
    assert [row["length"] for row in rows] == [20, 20]
    assert [row["source_start_ns"] - ros2.START for row in rows] == [200_000_000, 1_500_000_000]
    assert "the bag ends before False" in found.refused[0]


def broken(messages: list[Said], seconds: float, topic: str, **changes: Any) -> list[Said]:
    """The message of a topic at a time (of recording) with other content."""
    (place,) = [i for i, m in enumerate(messages) if m[1] == topic and abs(m[0] - seconds) < 1e-6]
    time, topic, type, content = messages[place]
    return [*messages[:place], (time, topic, type, {**content, **changes}), *messages[place + 1 :]]


@pytest.mark.parametrize(
    ("seconds", "topic", "changes", "message"),
    [
        (10.5, "/joint_states", {"position": [0, np.nan, 0]}, "not finite: nan in place 1"),
        (10.5, "/joint_states", {"position": [0, 1e300, 0]}, "not finite"),
        (10.5, "/joint_states", {"position": [0.0, 1.0]}, "2 values for 3 names"),
        (10.5, "/joint_states", {"name": ["shoulder", "elbow", "x"]}, "no wrist among shoulder"),
        (10.5 + LATE, PICTURES, {"data": b"\xff\xd8\xff no JPEG"}, "cannot be decoded"),
        (10.5 + LATE, PICTURES, "other size", "pictures of 48 x 40 become 64 x 40"),
    ],
)
def test_what_only_the_content_shows_refuses_its_episode(
    tmp_path: Path, seconds: float, topic: str, changes: Any, message: str
) -> None:
    messages = [m for start in (0, 10, 20) for m in (*arm(1.0, start), *camera(1.0, start))]
    if changes == "other size":
        changes = ros2.compressed(PICTURES, 10.5, ros2.picture(9, width=64))[3]
    messages = broken(messages, seconds, topic, **changes)
    found = take(tmp_path, ros2.in_time(messages), with_camera(episodes={"gap": 2.0}))
    assert lengths(tmp_path / "out") == [19, 19]
    (refused,) = found.refused
    assert message in refused
    assert topic in refused
    assert not found.report.errors


def test_the_size_of_most_pictures_is_the_one_that_stays(tmp_path: Path) -> None:
    small = [ros2.compressed(PICTURES, t / 20, ros2.picture(9, width=64)) for t in range(20)]
    messages = [*arm(1.0), *small]
    messages += [m for start in (10, 20) for m in (*arm(1.0, start), *camera(1.0, start))]
    found = take(tmp_path, ros2.in_time(messages), with_camera(episodes={"gap": 2.0}))
    assert "pictures of 64 x 40, not 48 x 40 as most are" in found.refused[0]
    info = read_json(tmp_path / "out/meta/info.json")
    assert info["features"][CAMERA]["shape"] == [40, 48, 3]


def test_messages_out_of_order_are_put_in_order(tmp_path: Path) -> None:
    """Joints are written up to 0.3 s late, one camera after all the rest, some messages twice."""
    rng = np.random.default_rng(1)
    shuffled = sorted(arm(2.0), key=lambda said: said[0] + rng.uniform(0, 0.3))
    pictures = sorted(camera(2.0), key=lambda said: said[0] + rng.uniform(0, 0.3))
    messages = [said for said in shuffled for _ in range(2)] + pictures
    take(tmp_path, messages, with_camera(), "shuffled")
    take(tmp_path, ros2.in_time([*arm(2.0), *camera(2.0)]), with_camera(), "ordered")
    for key in ("observation.state", "action"):
        shuffled, ordered = (column(tmp_path / name, key) for name in ("shuffled", "ordered"))
        np.testing.assert_array_equal(shuffled, ordered)
    videos = [next((tmp_path / n / "videos").rglob("*.mp4")) for n in ("shuffled", "ordered")]
    assert videos[0].read_bytes() == videos[1].read_bytes()


def test_pictures_too_far_out_of_order_are_not_kept_in_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lfr.importing.bag.fill.MOST_HELD", 3000)
    with pytest.raises(DataError, match="too far out of order; `mcap sort`"):
        take(tmp_path, [*arm(1.0), *reversed(camera(1.0))], with_camera())


def test_a_clock_that_goes_back_is_no_late_message(tmp_path: Path) -> None:
    """After 1 s the clock is set back by 5 s; sorted, two times would be mixed."""
    messages = [*arm(1.0, start=10), *arm(1.0, start=6)]
    with pytest.raises(DataError, match=r"the clock of /joint_states goes back"):
        take(tmp_path, messages, MAPPING)


def test_a_clock_that_jumps_ahead_parts_episodes(tmp_path: Path) -> None:
    messages = [*arm(1.0, start=-1.6e9), *arm(1.0)]
    with pytest.raises(DataError, match=r"has a clock jumped\?"):
        take(tmp_path, messages, MAPPING)
    take(tmp_path, messages, {**MAPPING, "episodes": {"gap": 1.0}})
    assert lengths(tmp_path / "out") == [19, 19]


def test_stamps_of_two_clocks_are_not_compared(tmp_path: Path) -> None:
    """The camera's clock is an hour ahead; the recorder's is one for all."""
    messages = ros2.in_time([*arm(1.0), *camera(1.0, start=3600, late=-3600)])
    found = take(tmp_path, messages, with_camera())
    assert found.clock == "log"
    assert any("two clocks, 3600.0 s apart" in note for note in found.notes)
    assert lengths(tmp_path / "out") == [19]
    with pytest.raises(DataError, match="no episode"):
        take(tmp_path, messages, with_camera(time="header"), "header")


def test_without_stamps_the_recorders_clock_counts(tmp_path: Path) -> None:
    unset = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    found = take(tmp_path, arm(1.0, header=unset), MAPPING)
    assert found.clock == "log"
    assert "100 messages without a stamp" in found.notes[0]
    with pytest.raises(DataError, match="say `time: log`"):
        take(tmp_path, arm(1.0, header=unset), {**MAPPING, "time": "header"}, "header")


@pytest.mark.parametrize("compression", list(CompressionType))
def test_chunks_of_every_compression_are_read(tmp_path: Path, compression: CompressionType) -> None:
    bag = ros2.write(tmp_path / "take.mcap", arm(1.0), compression=compression)
    take(tmp_path, bag, MAPPING)
    assert lengths(tmp_path / "out") == [19]


def test_a_cut_off_bag_is_read_as_far_as_it_is_whole(tmp_path: Path) -> None:
    whole = ros2.write(tmp_path / "whole.mcap", arm(2.0)).read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    found = take(tmp_path, tmp_path / "cut.mcap", MAPPING)
    assert "cut off; read as far as it is whole" in found.notes[0]
    (frames,) = lengths(tmp_path / "out")
    assert 5 < frames < 30


def test_a_damaged_bag_is_refused_with_what_mends_it(tmp_path: Path) -> None:
    data = bytearray(ros2.write(tmp_path / "bad.mcap", arm(2.0)).read_bytes())
    data[len(data) // 3] ^= 0xFF
    (tmp_path / "bad.mcap").write_bytes(data)
    with pytest.raises(DataError, match=r"`lfr recover .*bad.mcap` copies what is whole"):
        take(tmp_path, tmp_path / "bad.mcap", MAPPING)
    assert main(["recover", str(tmp_path / "bad.mcap")]) == 0
    take(tmp_path, tmp_path / "bad.recovered.mcap", {**MAPPING, "episodes": {"late": "cut"}})


@pytest.fixture
def split_bag(tmp_path: Path) -> Path:
    """A folder as `ros2 bag record -b` leaves it: an episode that goes on in a second file."""
    messages = ros2.in_time([*arm(2.0), *camera(2.0)])
    folder = tmp_path / "bag"
    ros2.write(folder / "bag_0.mcap", [m for m in messages if m[0] < 0.9])
    # the second file's topics come in another order, so its numbers of channels and schemas do too
    ros2.write(folder / "bag_1.mcap", sorted((m for m in messages if m[0] >= 0.9),
                                             key=lambda m: (m[0], m[1])))  # fmt: skip
    files = ["bag_0.mcap", "bag/bag_1.mcap"]  # as an old ros2 bag wrote it
    about = {"version": 5, "storage_identifier": "mcap", "relative_file_paths": files}
    YAML(typ="safe").dump({"rosbag2_bagfile_information": about}, folder / "metadata.yaml")
    return folder


def test_files_of_one_bag_are_one_episode(tmp_path: Path, split_bag: Path) -> None:
    take(tmp_path, split_bag, with_camera())
    assert lengths(tmp_path / "out") == [39]
    for name in ("take_10", "take_2"):
        shutil.copytree(split_bag, tmp_path / "session" / name)
    take(tmp_path, tmp_path / "session", with_camera(), "both")
    rows = pq.read_table(tmp_path / "both/meta/episodes").to_pylist()
    assert [(row["source_file"], row["length"]) for row in rows] == [
        ("take_2", 39),
        ("take_10", 39),
    ]


def test_what_is_no_bag_is_told(tmp_path: Path, split_bag: Path) -> None:
    cases: dict[str, str] = {
        "a.db3": "SQLite; `ros2 bag convert`",
        "a.bag": "ROS 1; `rosbags-convert`",
        "a.mcap.zstd": "`zstd -d`",
        "a.mcap": "not an MCAP file",
        "missing.mcap": "no such bag",
    }
    for name, message in cases.items():
        if name != "missing.mcap":
            (tmp_path / name).write_bytes(b"SQLite format 3")
        with pytest.raises(DataError, match=message):
            take(tmp_path, tmp_path / name, MAPPING)
    with pytest.raises(DataError, match="no messages"):
        take(tmp_path, ros2.write(tmp_path / "empty.mcap", []), MAPPING)
    (split_bag / "bag_1.mcap").unlink()
    with pytest.raises(DataError, match="a file of the bag is missing"):
        take(tmp_path, split_bag, MAPPING)
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(DataError, match="no bag in this folder"):
        take(tmp_path, empty, MAPPING)


def test_of_several_bags_one_that_is_wrong_is_refused(tmp_path: Path) -> None:
    session = tmp_path / "session"
    ros2.write(session / "take_1.mcap", [(0.0, "/other", "std_msgs/msg/Bool", {"data": True})])
    ros2.write(session / "take_2.mcap", arm(1.0))
    ros2.write(session / "take_3.mcap", arm(1.0))
    (session / "take_4.mcap").write_bytes(b"no bag")
    found = take(tmp_path, session, MAPPING)
    assert lengths(tmp_path / "out") == [19, 19]
    assert "no messages on this topic" in found.refused[0]
    assert "take_1.mcap" in found.refused[0]
    assert "not an MCAP file" in found.refused[1]
    with pytest.raises(DataError, match=r"no episode that can be taken.*no messages on this topic"):
        take(tmp_path, session, with_camera(), "none")


def test_a_bag_given_twice_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = str(ros2.write(tmp_path / "take.mcap", arm(1.0)))
    YAML(typ="safe").dump(MAPPING, tmp_path / "m.yaml")
    options = ["--mapping", str(tmp_path / "m.yaml"), "--to", str(tmp_path / "out")]
    assert main(["import", bag, bag, *options]) == 2
    assert "given twice" in capsys.readouterr().err
    assert main(["import", bag, *options, "--mask", "train"]) == 2
    assert "not for bags: --mask" in capsys.readouterr().err
    assert main(["import", bag, "--to", str(tmp_path / "out")]) == 2
    assert "`lfr columns" in capsys.readouterr().err
