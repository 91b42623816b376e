"""Logs are verified as datasets are: each fault in its log, other people's files for damage."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.records import Channel, Message
from mcap.writer import CompressionType, Writer

from lfr import cli
from lfr.curation.verify import Report
from lfr.curation.verify_logs import verify_logs
from lfr.data import messages
from lfr.data.log import EpisodeLog, Frame
from lfr.data.log_reader import read_log
from lfr.errors import DataError

from ..data.made_up import info
from . import made_up

LENGTHS = (12, 9, 15)
SIZE = 32


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("logs") / "panda-lift"
    made_up.write_all(folder, LENGTHS, SIZE)
    return folder


@pytest.fixture
def logs(sound: Path, tmp_path: Path) -> Path:
    return shutil.copytree(sound, tmp_path / "panda-lift")


def test_sound_logs_have_no_finding(sound: Path) -> None:
    report = verify_logs(sound, pictures=1)
    assert report.findings == ()
    assert (report.episodes, report.frames) == (len(LENGTHS), sum(LENGTHS))
    one = verify_logs(sound / "episode-000001.mcap")
    assert one.findings == ()
    assert (one.episodes, one.frames) == (1, 9)


Edit = Callable[[Channel, Message], tuple[int, bytes] | None]


def rewritten(log: Path, edit: Edit, metadata: Callable[[dict[str, dict]], object] = dict) -> None:
    """A log copied by the `mcap` package, each message's time and content as `edit` has it."""
    with log.open("rb") as stream:
        reader = make_reader(stream)
        records = {m.name: dict(m.metadata) for m in reader.iter_metadata()}
        every = list(reader.iter_messages(log_time_order=False))
    metadata(records)
    with log.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        for name, record in records.items():
            writer.add_metadata(name, record)
        channels: dict[int, int] = {}
        for schema, channel, message in every:
            assert schema is not None
            if channel.id not in channels:
                id = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, id
                )
            if (new := edit(channel, message)) is not None:
                writer.add_message(channels[channel.id], new[0], new[1], new[0])
        writer.finish()


def same(channel: Channel, message: Message) -> tuple[int, bytes]:
    return message.log_time, message.data


def without(topic: str) -> Edit:
    return lambda c, m: None if c.topic == topic else same(c, m)


def later(topic: str, after: float, by: float) -> Edit:
    """Messages of a topic moved in time, from `after` s on."""
    starts: dict[str, int] = {}

    def edit(channel: Channel, message: Message) -> tuple[int, bytes]:
        start = starts.setdefault(channel.topic, message.log_time)
        moved = channel.topic == topic and message.log_time - start >= after * 1e9
        return message.log_time + round(moved * by * 1e9), message.data

    return edit


def not_pictures(channel: Channel, message: Message) -> tuple[int, bytes]:
    """The JPEG files without their first bytes."""
    content = message.data
    if channel.topic.startswith(messages.CAMERA):
        content = content.replace(b"\xff\xd8\xff", bytes(3))
    return message.log_time, content


def changed(**values: str) -> Callable[[dict[str, dict]], object]:
    return lambda records: records["outcome"].update(values)


def logged(seed: int = 1, **kwargs: Any) -> Callable[[Path], object]:
    """The log written anew, of another episode or of frames that are edited."""
    edit: Callable[[list[Frame]], object] = kwargs.pop("edit", lambda frames: None)

    def write(log: Path) -> None:
        frames = made_up.frames(kwargs.pop("of", seed), 9, SIZE)
        edit(frames)
        with EpisodeLog(log, replace(info(seed), **kwargs)) as out:
            for frame in frames:
                out.frame(frame)
            out.finish(np.arange(30.0), body_poses=frames[-1].body_poses)

    return write


def put(name: str, value: Any) -> Callable[[list[Frame]], object]:
    return lambda frames: frames.__setitem__(4, replace(frames[4], **{name: value}))


def damaged(log: Path) -> None:
    content = bytearray(log.read_bytes())
    content[len(content) // 2] ^= 0xFF
    log.write_bytes(content)


def shortened(kept: float) -> Callable[[Path], object]:
    return lambda log: log.write_bytes(log.read_bytes()[: int(kept * log.stat().st_size)])


NAN = float("nan")
BROKEN: dict[str, tuple[Callable[[Path], object], str, str, str]] = {
    "a byte": (damaged, "damaged-file", "error", "checksums say"),
    "cut off": (shortened(0.7), "damaged-file", "error", "cut off; `lfr recover`"),
    "empty": (shortened(0), "damaged-file", "error", "not an MCAP file"),
    "only its head": (lambda log: log.write_bytes(log.read_bytes()[:8]), "damaged-file", "error",
                      "cut off"),
    "a topic gone": (lambda log: rewritten(log, without("/reward")), "log", "error",
                     "column /reward, found 0 messages, expected 9"),
    "a camera's picture gone": (lambda log: rewritten(
        log, lambda c, m: None if c.topic == "/camera/agentview" and m.log_time % 10**9 > 395e6
        and m.log_time % 10**9 < 405e6 else same(c, m)), "log", "error",
        "/camera/agentview, found 8 messages, expected 9"),
    "no outcome": (lambda log: rewritten(log, same, lambda r: r.pop("outcome")), "log", "error",
                   "no outcome"),
    "no schema": (lambda log: rewritten(log, same, lambda r: r.pop("features")), "log", "error",
                  "expected metadata episode, features, outcome"),
    "another number of frames": (lambda log: rewritten(log, same, changed(frames="10")), "log",
                                 "error", "found 9 messages, expected 10"),
    "another outcome": (lambda log: rewritten(log, same, changed(success="false")), "success",
                        "error", "found False, expected True"),
    "a gap": (lambda log: rewritten(log, later("/action", 0.2, 0.5)), "gap-in-time", "error",
              "column /action, frames 3 to 4, found 0.55 s, expected 0.05 s"),
    "a jump back": (lambda log: rewritten(log, later("/action", 0.2, -0.5)), "jump-in-time",
                    "error", "column /action, frames 3 to 4, found -0.45 s"),
    "a late topic": (lambda log: rewritten(log, later("/reward", 0.0, 0.1)), "time-start", "error",
                     r"column /reward, found \+0.1 s"),
    "not pictures": (lambda log: rewritten(log, not_pictures), "damaged-picture", "error",
                     r"column /camera/agentview, frames 0 to 0"),
    "NaN": (logged(edit=put("reward", NAN)), "not-finite", "error",
            "column next.reward, frames 4 to 4"),
    "a state of the simulator": (logged(edit=put("simulator_state", np.full(30, np.inf))),
                                 "not-finite", "error", "column /simulator_state"),
    "an action beyond": (logged(edit=put("action", np.full(7, 1.5))), "range", "error",
                         "column action.dx, frames 4 to 4, found 1.5, expected -1 to 1"),
    "another task": (logged(task="stack"), "log", "error",
                     "another kind than episode-000000.mcap.*column task, found stack"),
    "another robot": (logged(robot="sawyer"), "log", "error", "column robot, found sawyer"),
    "a seed twice": (logged(seed=0, of=1), "repeated-seed", "warning", "episode-000000.mcap's"),
    "a held-out seed": (logged(seed=2_000_000, of=1), "leaked-seed", "warning", "held-out"),
    "the same log": (lambda log: shutil.copy(log.with_name("episode-000000.mcap"), log), "log",
                     "error", "the same log as episode-000000.mcap"),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_wrong_is_found_in_its_log(logs: Path, name: str) -> None:
    damage, check, severity, shown = BROKEN[name]
    damage(logs / "episode-000001.mcap")
    found = verify_logs(logs, pictures=1).findings
    said = [str(finding) for finding in found]
    assert any(
        (one.check, one.severity) == (check, severity) and re.search(shown, line)
        for one, line in zip(found, said, strict=True)
    ), "\n".join(said)
    assert {(one.file, one.episode) for one in found} == {("episode-000001.mcap", 1)}
    assert json.dumps(verify_logs(logs).as_json(), allow_nan=False)


def test_the_rewritten_log_is_the_same(logs: Path) -> None:
    """So that the faults above are the only ones."""
    before = read_log(logs / "episode-000001.mcap")
    rewritten(logs / "episode-000001.mcap", same)
    after = read_log(logs / "episode-000001.mcap")
    assert verify_logs(logs, pictures=1).findings == ()
    np.testing.assert_array_equal(before.simulator_state, after.simulator_state)


@pytest.mark.parametrize("text", ["{", "3", '"x"', "[1]", "{}", "null", "[" * 9999, "1e999"])
def test_whatever_stands_in_the_metadata_is_no_traceback(
    sound: Path, text: str, tmp_path: Path
) -> None:
    with (sound / "episode-000001.mcap").open("rb") as stream:
        records = {m.name: m.metadata for m in make_reader(stream).iter_metadata()}
    for name in ("episode", "features", "outcome"):
        for key in records[name]:
            log = tmp_path / "e.mcap"
            shutil.copy(sound / "episode-000001.mcap", log)
            rewritten(log, same, lambda r, n=name, k=key: r[n].update({k: text}))
            report = verify_logs(log, pictures=4)
            assert report.findings or (name, key) not in (("outcome", "frames"), ("episode", "fps"))
            assert cli.main(["view", str(log), "--list"]) == 0


def bag(path: Path, *, back: bool = False, schema: bytes = b"float64 data\n") -> Path:
    """As a ROS 2 recorder of rewards would write it: no checksum over all, topics like ours."""
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=500, compression=CompressionType.NONE,
                        enable_data_crcs=False)  # fmt: skip
        writer.start("ros2")
        id = writer.register_schema("std_msgs/msg/Float64", "ros2msg", schema)
        channels = [writer.register_channel(topic, "cdr", id) for topic in ("/reward", "/action")]
        for step in range(60):
            time = 10**18 + (step - 2 * (back and step == 40)) * 10**7
            for channel in channels:
                writer.add_message(channel, time, bytes(12), time)
        writer.finish()
    return path


def test_other_peoples_files_are_looked_at_for_damage_alone(tmp_path: Path) -> None:
    bag(tmp_path / "a.mcap")
    bag(tmp_path / "b.mcap", back=True)
    bag(tmp_path / "c.mcap", schema=b"\xff\xfe")
    damaged(bag(tmp_path / "d.mcap"))
    shortened(0.6)(bag(tmp_path / "e.mcap"))
    report = verify_logs(tmp_path)
    assert (report.episodes, report.frames) == (0, 0)
    said: dict[str, set[str]] = {}
    for one in report.findings:
        said.setdefault(one.file, set()).add(one.check)
    assert said == {
        "a.mcap": {"foreign-log"},
        "b.mcap": {"foreign-log", "jump-in-time"},
        "c.mcap": {"foreign-log", "schema"},
        "d.mcap": {"foreign-log", "damaged-file"},
        "e.mcap": {"foreign-log", "damaged-file"},
    }
    assert [one.file for one in report.warnings if one.check == "foreign-log"] == sorted(said)


def test_they_are_in_the_list_as_what_they_are(
    logs: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Rewards of theirs are no rewards of ours, whatever their topic is called."""
    bag(logs / "run.mcap")
    assert cli.main(["view", str(logs), "--list"]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert printed[4].split(maxsplit=6)[6] == "run.mcap: no log of lfr"
    assert cli.main(["view", str(logs / "run.mcap"), "--save", "x.rrd"]) == 2
    assert "foreign MCAP file" in capsys.readouterr().err


def test_the_command(logs: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    log = logs / "episode-000001.mcap"
    assert cli.main(["verify", str(logs)]) == 0
    assert cli.main(["verify", str(log)]) == 0
    (logs / "next.mcap.partial").write_bytes(log.read_bytes()[:900])
    assert cli.main(["verify", str(logs)]) == 0
    assert "an unfinished log" in capsys.readouterr().out
    assert cli.main(["verify", str(logs / "next.mcap.partial")]) == 1
    damaged(log)
    assert cli.main(["verify", str(log), "--json"]) == 1
    printed = capsys.readouterr().out
    content = json.loads(printed[printed.index("{") :])
    assert content["findings"][0]["file"] == log.name
    (tmp_path / "notes.txt").write_text("notes")
    assert cli.main(["verify", str(tmp_path / "notes.txt")]) == 2
    with pytest.raises(DataError, match="not an MCAP file"):
        verify_logs(tmp_path / "notes.txt")
    assert isinstance(verify_logs(logs), Report)
