"""The log gives back what was given to it, is the same file each time, and never half a file."""

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.writer import Writer

from lfr.data import log as log_module
from lfr.data.episode import FEATURES
from lfr.data.log import EpisodeLog
from lfr.data.log_reader import body_poses, list_logs, read_log
from lfr.data.messages import CameraModel
from lfr.errors import DataError

from . import made_up

FOLDER = Path(__file__).parent
ALL_FLOAT64 = st.floats(allow_nan=True, allow_infinity=True, width=64)


def test_what_was_logged_is_read_back(tmp_path: Path) -> None:
    logged = made_up.write(tmp_path / "e.mcap", seed=3, length=45)
    episode = read_log(tmp_path / "e.mcap")

    observation = np.array([f.observation for f in logged])
    expected = {
        "observation.state": observation[:, :4].astype(np.float32),
        "observation.environment_state": observation[:, 4:].astype(np.float32),
        "observation.joint_position": np.float32([f.joint_position for f in logged]),
        "action": np.float32([f.action for f in logged]),
        "next.reward": np.float32([f.reward for f in logged]),
        "next.success": np.array([f.success for f in logged]),
        "next.done": np.arange(45) == 44,
    }
    assert list(episode.features) == [f.key for f in FEATURES] == list(expected)
    for key, values in expected.items():
        assert episode.features[key].dtype == values.dtype
        np.testing.assert_array_equal(episode.features[key], values, err_msg=key)
    states = [*(f.simulator_state for f in logged), np.arange(30.0)]
    np.testing.assert_array_equal(episode.simulator_state, states)
    assert (episode.robot, episode.task, episode.seed) == ("panda", "lift", 3)
    assert episode.success
    assert len(episode) == 45
    assert episode.metadata["instruction"] == "Lift the cube."
    assert episode.metadata["provenance"]["python"].startswith("3.12")
    assert episode.schema == made_up.info().features


@settings(
    max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    states=arrays(
        np.float64, st.tuples(st.integers(2, 5), st.integers(1, 40)), elements=ALL_FLOAT64
    )
)
def test_any_simulator_state_comes_back_bit_by_bit(tmp_path: Path, states: np.ndarray) -> None:
    frame = made_up.frames(seed=0, length=1)[0]
    with EpisodeLog(tmp_path / "e.mcap", made_up.info()) as log:
        for state in states[:-1]:
            log.frame(type(frame)(**{**vars(frame), "simulator_state": state}))
        log.finish(states[-1])
    found = read_log(tmp_path / "e.mcap").simulator_state
    assert found.tobytes() == states.tobytes()


@pytest.mark.parametrize("value", [0.0, -0.0, 5e-324, np.pi])
def test_zero_and_its_sign_are_written(tmp_path: Path, value: float) -> None:
    frame = made_up.frames(seed=0, length=1)[0]
    with EpisodeLog(tmp_path / "e.mcap", made_up.info()) as log:
        log.frame(type(frame)(**{**vars(frame), "action": np.full(7, value), "reward": value}))
        log.finish(np.zeros(30))
    found = read_log(tmp_path / "e.mcap").features
    assert found["action"].tobytes() == np.full(7, value, np.float32).tobytes()


def test_the_executed_action_is_kept_exactly_beside_the_label(tmp_path: Path) -> None:
    logged = made_up.frames(seed=4, length=6)
    for name, noise in (("clean", None), ("noisy", np.full(7, 0.1))):
        with EpisodeLog(tmp_path / f"{name}.mcap", made_up.info()) as log:
            for f in logged:
                executed = None if noise is None else f.action + noise
                log.frame(type(f)(**{**vars(f), "executed_action": executed}))
            log.finish(np.zeros(30))
    labels = np.array([f.action for f in logged])
    clean, noisy = (read_log(tmp_path / f"{name}.mcap") for name in ("clean", "noisy"))
    np.testing.assert_array_equal(clean.executed_action, labels)
    np.testing.assert_array_equal(noisy.executed_action, labels + 0.1)
    np.testing.assert_array_equal(noisy.features["action"], labels.astype(np.float32))


def test_poses_are_read_back(tmp_path: Path) -> None:
    logged = made_up.write(tmp_path / "e.mcap", seed=1, length=5)
    poses = body_poses(tmp_path / "e.mcap")
    assert set(poses) == {"hand", "cube"}
    expected = [np.concatenate(f.body_poses["cube"]) for f in [*logged, logged[-1]]]
    np.testing.assert_array_equal(poses["cube"], expected)


def test_images_are_jpeg_and_the_camera_is_calibrated(tmp_path: Path) -> None:
    camera = CameraModel(32, 32, np.diag([40.0, 40.0, 1.0]), np.ones(3), np.array([1.0, 0, 0, 0]))
    logged = made_up.frames(seed=0, length=3, image_size=32)
    with EpisodeLog(tmp_path / "e.mcap", made_up.info(), cameras={"agentview": camera}) as log:
        for frame in logged:
            log.frame(frame)
        log.finish(np.zeros(30))
    files = read_log(tmp_path / "e.mcap").images["agentview"]
    assert len(files) == 3
    for file, frame in zip(files, logged, strict=True):
        assert np.abs(_decode(file) - frame.images["agentview"].astype(int)).max() < 12
    assert body_poses(tmp_path / "e.mcap")["agentview"].tolist() == [[1, 1, 1, 1, 0, 0, 0]]
    with (tmp_path / "e.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    schemas = {c.topic: summary.schemas[c.schema_id].name for c in summary.channels.values()}
    assert schemas["/camera/agentview/calibration"] == "foxglove.CameraCalibration"
    assert schemas["/joint_states"] == "foxglove.JointStates"
    assert schemas["/tf"] == "foxglove.FrameTransforms"


def test_a_camera_that_moves_has_a_pose_in_every_frame(tmp_path: Path) -> None:
    from dataclasses import replace

    intrinsics = np.array([[30.0, 0.0, 16.0], [0.0, 30.0, 24.0], [0.0, 0.0, 1.0]])
    logged = [
        replace(
            frame,
            body_poses={**frame.body_poses, "wrist": (np.full(3, float(t)), np.eye(4)[0])},
            images={"wrist": np.zeros((48, 32, 3), np.uint8)},
        )
        for t, frame in enumerate(made_up.frames(seed=0, length=3))
    ]
    models = {"wrist": CameraModel(32, 48, intrinsics)}
    with EpisodeLog(tmp_path / "e.mcap", made_up.info(), models) as log:
        for frame in logged:
            log.frame(frame)
        log.finish(np.zeros(30), logged[-1].body_poses)
    poses = body_poses(tmp_path / "e.mcap")["wrist"]
    np.testing.assert_array_equal(poses[:, 0], [0, 1, 2, 2])
    found = read_log(tmp_path / "e.mcap").cameras["wrist"]
    assert (found.width, found.height, found.position) == (32, 48, None)
    np.testing.assert_array_equal(found.intrinsics, intrinsics)


def _decode(jpeg: bytes) -> np.ndarray:
    import io

    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(jpeg)), dtype=int)


def test_the_same_episode_is_the_same_file_in_another_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(log_module, "_provenance", dict)  # a commit in between is another file
    for name in "ab":
        made_up.write(tmp_path / f"{name}.mcap", seed=2, length=25, image_size=16)
    code = "import lfr.data.log; lfr.data.log._provenance = dict\n"
    _python(
        code
        + f"made_up.write(Path({str(tmp_path)!r}) / 'c.mcap', seed=2, length=25, image_size=16)"
    )
    contents = {(tmp_path / f"{name}.mcap").read_bytes() for name in "abc"}
    assert len(contents) == 1


def test_the_settled_summary_is_sound(tmp_path: Path) -> None:
    made_up.write(tmp_path / "e.mcap", seed=0, length=3, image_size=16)
    with (tmp_path / "e.mcap").open("rb") as stream:
        data = stream.read()
        stream.seek(0)
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert list(summary.channels) == sorted(summary.channels)
    # the footer's CRC covers everything from the summary's start up to the CRC itself
    import zlib

    start = int.from_bytes(data[-28:-20], "little")
    assert zlib.crc32(data[start:-12]) == int.from_bytes(data[-12:-8], "little")


def test_rerun_and_the_topics_are_typed(tmp_path: Path) -> None:
    from rerun.experimental import McapReader

    logged = made_up.write(tmp_path / "e.mcap", seed=0, length=4)
    columns: dict[str, list[dict[str, float]]] = {}
    for chunk in McapReader(str(tmp_path / "e.mcap")).stream().to_chunks():
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            if name.startswith("lfr.") and name.endswith(":message"):
                rows = columns.setdefault(chunk.entity_path, [])
                rows += [row[0] for row in batch.column(name).to_pylist()]
    assert [row["gripper"] for row in columns["/action"]] == [f.action[6] for f in logged]
    assert [row["reward"] for row in columns["/reward"]] == [f.reward for f in logged]
    assert [row["success"] for row in columns["/success"]] == [0.0, 0.0, 0.0, 1.0]
    assert "cube_pos_z" in columns["/observation"][0]


def test_unfinished_episodes_leave_nothing(tmp_path: Path) -> None:
    frame = made_up.frames(seed=0, length=1)[0]
    with EpisodeLog(tmp_path / "forgotten.mcap", made_up.info()) as log:
        log.frame(frame)
    with suppress(RuntimeError), EpisodeLog(tmp_path / "failed.mcap", made_up.info()) as log:
        log.frame(frame)
        raise RuntimeError
    with EpisodeLog(tmp_path / "abandoned.mcap", made_up.info()) as log:
        log.frame(frame)
        log.abandon()
    assert list(tmp_path.iterdir()) == []


def test_abandoning_a_second_attempt_keeps_the_first(tmp_path: Path) -> None:
    made_up.write(tmp_path / "e.mcap", seed=0, length=2)
    before = (tmp_path / "e.mcap").read_bytes()
    with EpisodeLog(tmp_path / "e.mcap", made_up.info()) as log:
        log.frame(made_up.frames(seed=5, length=1)[0])
    assert (tmp_path / "e.mcap").read_bytes() == before


def test_kill_9_leaves_only_the_partial_with_all_but_the_last_second(tmp_path: Path) -> None:
    code = (
        f"log = EpisodeLog(Path({str(tmp_path)!r}) / 'e.mcap', made_up.info())\n"
        "for frame in made_up.frames(seed=0, length=50): log.frame(frame)\n"
        "os.kill(os.getpid(), 9)"
    )
    assert _python(code, check=False) == -signal.SIGKILL
    assert [p.name for p in tmp_path.iterdir()] == ["e.mcap.partial"]
    with pytest.raises(DataError, match="1 unfinished"):
        list_logs(tmp_path)
    with pytest.raises(DataError, match="cut-off MCAP"):
        read_log(tmp_path / "e.mcap.partial")

    from mcap.stream_reader import StreamReader

    seen = 0
    with (tmp_path / "e.mcap.partial").open("rb") as stream, suppress(McapError):  # at the cut
        for record in StreamReader(stream).records:
            seen += type(record).__name__ == "Message"
    assert seen >= 40 * 7
    # and the next attempt goes over it
    made_up.write(tmp_path / "e.mcap", seed=0, length=3)
    assert [p.name for p in tmp_path.iterdir()] == ["e.mcap"]


def test_a_full_disk_is_said_and_leaves_nothing(tmp_path: Path) -> None:
    code = (
        "import resource\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))\n"
        "try:\n"
        f"    made_up.write(Path({str(tmp_path)!r}) / 'e.mcap', seed=0, length=90)\n"
        "except DataError as error:\n"
        "    assert 'disk' in str(error), error\n"
        "    sys.exit(7)"
    )
    assert _python(code, check=False) == 7
    assert list(tmp_path.iterdir()) == []


def _python(code: str, check: bool = True) -> int:
    """Exit status of `code` in a process of its own, with made_up and the log's names at hand."""
    header = (
        "import os, sys\nfrom pathlib import Path\n"
        f"sys.path.insert(0, {str(FOLDER)!r})\nimport made_up\n"
        "from lfr.data.log import EpisodeLog\nfrom lfr.errors import DataError\n"
    )
    root = str(FOLDER.parent.parent)
    environment = {**os.environ, "PYTHONPATH": root}
    return subprocess.run(
        [sys.executable, "-c", header + code], check=check, env=environment
    ).returncode


def test_bad_files_are_named_with_what_was_found(tmp_path: Path) -> None:
    made_up.write(tmp_path / "e.mcap", seed=0, length=30)
    whole = (tmp_path / "e.mcap").read_bytes()
    cases = {
        "text.mcap": (b"hello", "not an MCAP file"),
        "empty.mcap": (b"", "not an MCAP file"),
        "magic.mcap": (whole[:8], "cut-off"),
        "half.mcap": (whole[: len(whole) // 2], "cut-off"),
        "last.mcap": (whole[:-1], "cut-off"),
    }
    for name, (content, message) in cases.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(DataError, match=message) as caught:
            read_log(tmp_path / name)
        assert name in str(caught.value)
        assert "\n" not in str(caught.value)
    with pytest.raises(DataError, match="no such log"):
        read_log(tmp_path / "absent.mcap")
    with pytest.raises(DataError, match=r"no logs.*expected \*\.mcap"):
        list_logs(tmp_path / "nowhere")


def test_a_foreign_mcap_is_said_to_be_foreign(tmp_path: Path) -> None:
    with (tmp_path / "foreign.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("lfr.Action", "protobuf", b"\xff\xff")
        channel = writer.register_channel("/action", "protobuf", schema)
        writer.add_message(channel, 0, b"x", 0)
        writer.finish()
    with pytest.raises(DataError, match="foreign"):
        read_log(tmp_path / "foreign.mcap")


def test_a_log_that_lost_messages_is_refused(tmp_path: Path) -> None:
    """A log of lfr, its metadata whole, without its actions."""
    made_up.write(tmp_path / "e.mcap", seed=0, length=5)
    source, lossy = (tmp_path / "e.mcap").open("rb"), (tmp_path / "lossy.mcap").open("wb")
    with source, lossy:
        reader, writer = make_reader(source), Writer(lossy)
        writer.start()
        channels = {}
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            if channel.topic == "/action":
                continue
            if channel.topic not in channels:
                id = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = writer.register_channel(channel.topic, "protobuf", id)
            writer.add_message(channels[channel.topic], message.log_time, message.data, 0)
        for metadata in reader.iter_metadata():
            writer.add_metadata(metadata.name, metadata.metadata)
        writer.finish()
    with pytest.raises(DataError, match=r"column /action, found 0 messages, expected 5"):
        read_log(tmp_path / "lossy.mcap")


@pytest.fixture(scope="module")
def whole_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("log") / "e.mcap"
    made_up.write(path, seed=0, length=30)
    return path


@settings(max_examples=100)
@given(at=st.floats(0, 1, exclude_max=True), flip=st.integers(1, 255))
def test_a_flipped_byte_is_refused(whole_log: Path, at: float, flip: int) -> None:
    """No byte of the file, its metadata's too, can turn unseen into another episode."""
    damaged = bytearray(whole_log.read_bytes())
    damaged[int(at * len(damaged))] ^= flip
    path = whole_log.with_name("damaged.mcap")
    path.write_bytes(damaged)
    with pytest.raises(DataError, match=r"damaged\.mcap"):
        read_log(path)


def test_another_length_than_the_names_is_an_error(tmp_path: Path) -> None:
    frame = made_up.frames(seed=0, length=1)[0]
    with EpisodeLog(tmp_path / "e.mcap", made_up.info()) as log:
        with pytest.raises(ValueError, match="argument 2 is shorter"):
            log.frame(type(frame)(**{**vars(frame), "action": np.zeros(6)}))
        with pytest.raises(ValueError, match="at least one frame"):
            log.finish(np.zeros(30))
