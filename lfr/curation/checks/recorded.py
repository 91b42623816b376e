"""One MCAP log: the file, and what of an episode it holds."""

from __future__ import annotations

import io
from array import array
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from google.protobuf.message import DecodeError
from mcap.records import Message, Schema
from numpy.typing import NDArray

from lfr.artifacts import parse_json
from lfr.curation.checks.ranges import bounds
from lfr.curation.checks.values import SLACK
from lfr.curation.finding import Finding, first
from lfr.curation.salvage import Salvage, salvage
from lfr.data import messages
from lfr.data.episode import FPS, SUCCESS, Episode
from lfr.data.log_reader import PER_FRAME
from lfr.data.mcap_file import DAMAGE, check_sums

Where = Mapping[str, Any]
TOLERANCE_NS = 100_000  # LeRobot's 0.1 ms; a recorder that counts frames has no error at all
STEPPED = (*PER_FRAME, messages.SIMULATOR_STATE, messages.EXECUTED_ACTION)


@dataclass
class Container:
    """A log as a file of messages.

    Attributes:
        saved: all of it but the messages.
        times: ns, when each message of a channel was logged.
        findings: what is wrong with the file.
    """

    saved: Salvage
    times: dict[int, NDArray[np.uint64]]
    findings: list[Finding] = field(default_factory=list)

    @property
    def is_ours(self) -> bool:
        """Whether it is a log of this project, or was to become one."""
        return any(self.saved.record(name) is not None for name in ("episode", "features"))

    @property
    def is_whole(self) -> bool:
        return not self.findings

    def topic(self, channel: int) -> str:
        known = self.saved.channels.get(channel)
        return f"channel {channel}" if known is None else known.topic


def check_container(log: Path, where: Where) -> Container:
    """Read a log's records, in bounded memory, by their checksums.

    Raises:
        DataError: it is no MCAP file.
    """
    times: dict[int, array[int]] = defaultdict(lambda: array("Q"))

    def take(message: Message) -> None:
        times[message.channel_id].append(message.log_time)

    saved = salvage(log, take)
    found = {id: np.frombuffer(each, np.uint64) for id, each in times.items()}
    return Container(saved, found, list(_damage(log, saved, where)))


def _damage(log: Path, saved: Salvage, where: Where) -> Iterator[Finding]:
    mend = "`lfr recover` keeps what is whole"
    if saved.damaged:
        yield Finding("damaged-file", f"chunks that are not what their checksums say; {mend}",
                      found=f"{saved.damaged} damaged", **where)  # fmt: skip
    if not saved.finished:
        yield Finding("damaged-file", f"cut off; {mend}", **where,
                      found=f"{saved.unread} bytes after the last whole record")  # fmt: skip
    if saved.nameless:
        of = f" of {', '.join(saved.lost_topics)}" if saved.lost_topics else ""
        yield Finding("damaged-file", "messages whose schema or channel is lost",
                      found=f"{saved.nameless}{of}", **where)  # fmt: skip
    if saved.finished and not saved.damaged:
        if saved.record("episode") is not None and saved.record("outcome") is None:
            yield Finding("log", f"no outcome: its recorder did not finish; {mend}", **where)
        try:
            with log.open("rb") as stream:
                check_sums(stream)
        except DAMAGE as error:
            yield Finding("damaged-file", "a checksum differs", found=str(error), **where)


def check_foreign(container: Container, where: Where) -> Iterator[Finding]:
    """What can be said of an MCAP file that this project did not write."""
    saved = container.saved
    topics = sorted({channel.topic for channel in saved.channels.values()})
    yield Finding("foreign-log", "no log of lfr, but another MCAP file: looked at for damage alone",
                  "warning", found=", ".join(topics) or "no topics", **where)  # fmt: skip
    for channel in saved.channels.values():
        schema = saved.schemas.get(channel.schema_id)
        if schema is not None and (reason := _unreadable(schema)):
            yield Finding("schema", "a schema that cannot be read", column=channel.topic,
                          found=f"{schema.name}: {reason}", **where)  # fmt: skip
    for id, times in container.times.items():
        back = np.flatnonzero(times[1:] < times[:-1])
        if len(back):
            at = int(back[0])
            yield Finding("jump-in-time", "log times that go back", "warning", **where,
                          column=container.topic(id), found=int(times[at + 1]),
                          expected=f"at least {int(times[at])} ns",
                          places=len(back))  # fmt: skip


def _unreadable(schema: Schema) -> str:
    try:
        if schema.encoding == "protobuf":
            messages.message_class(schema.name, schema.data)
        elif schema.encoding == "jsonschema":
            parse_json(schema.data.decode("utf-8"))
        elif schema.encoding in ("ros2msg", "ros1msg", "ros2idl", "omgidl"):
            schema.data.decode("utf-8")
    except (DecodeError, KeyError, TypeError, ValueError) as error:
        return str(error)
    return ""


def check_log(
    episode: Episode, container: Container, where: Where, pictures: int | None
) -> Iterator[Finding]:
    """What is wrong with the episode of a log that could be read.

    Args:
        pictures: every how many frames of a camera one is decoded; None leaves them.
    """
    yield from _times(episode, container, where)
    yield from _values(episode, where)
    if episode.success != (found := bool(np.any(episode.features[SUCCESS]))):
        yield Finding("success", "another outcome than its frames have", column="outcome",
                      found=episode.success, expected=found, **where)  # fmt: skip
    if pictures is not None:
        yield from _pictures(episode, where, pictures)


def _times(episode: Episode, container: Container, where: Where) -> Iterator[Finding]:
    """Every topic of a frame has its messages 1 / fps apart, and all begin together."""
    step = round(1e9 / (episode.metadata.get("fps") or FPS))
    begins: dict[str, int] = {}
    for id, times in container.times.items():
        topic = container.topic(id)
        camera = topic.startswith(messages.CAMERA) and not topic.endswith(messages.CALIBRATION)
        if not (topic in STEPPED or camera) or not len(times):
            continue
        begins[topic] = int(times[0])
        steps = np.diff(times.astype(np.int64))
        for check, message, wrong in (
            ("gap-in-time", "a gap in time", steps > step + TOLERANCE_NS),
            ("jump-in-time", "time that stands still or goes back", steps < step - TOLERANCE_NS),
        ):
            if wrong.any():
                at, places = first(wrong)
                yield Finding(check, message, column=topic, frames=(at, at + 1),
                              found=f"{steps[at] / 1e9:g} s", expected=f"{step / 1e9:g} s",
                              places=places, **where)  # fmt: skip
    start = begins.get(messages.OBSERVATION)
    for topic, begin in begins.items():
        if start is not None and abs(begin - start) > TOLERANCE_NS:
            yield Finding("time-start", "messages that do not begin with the observations'",
                          column=topic, found=f"{(begin - start) / 1e9:+g} s", expected="0 s",
                          **where)  # fmt: skip


def _values(episode: Episode, where: Where) -> Iterator[Finding]:
    every: dict[str, NDArray] = dict(episode.features)
    every[messages.SIMULATOR_STATE] = episode.simulator_state
    if episode.executed_action is not None:
        every[messages.EXECUTED_ACTION] = episode.executed_action
    schema = episode.metadata["features"]
    for key, values in every.items():
        rows = values.reshape(len(values), -1)
        finite = np.isfinite(rows) if rows.dtype.kind == "f" else np.ones(rows.shape, bool)
        bad = ~finite.all(axis=1)
        if bad.any():
            at, places = first(bad)
            yield Finding("not-finite", "NaN or infinite", column=key, frames=(at, at),
                          found=rows[at].tolist(), expected="finite numbers", places=places,
                          **where)  # fmt: skip
        if key not in schema:
            continue
        names = schema[key]["names"]
        for i, (low, high) in bounds(key, schema, episode.robot).items():
            column = rows[:, i]
            wrong = (column < low - SLACK) | (column > high + SLACK)
            if wrong.any():
                at, places = first(wrong)
                yield Finding("range", "out of its range", column=f"{key}.{names[i]}",
                              frames=(at, at), found=float(column[at]),
                              expected=f"{low:g} to {high:g}", places=places, **where)  # fmt: skip


def _pictures(episode: Episode, where: Where, stride: int) -> Iterator[Finding]:
    """Every picture is one, and of its camera's size."""
    from PIL import Image

    for camera, files in episode.images.items():
        size: tuple[int, int] | None = None
        for frame in range(0, len(files), max(stride, 1)):
            said: dict[str, Any] = {**where, "column": messages.CAMERA + camera,
                                    "frames": (frame, frame)}  # fmt: skip
            try:
                with Image.open(io.BytesIO(files[frame])) as picture:
                    picture.load()
                    size = size or picture.size
                    if picture.size != size:
                        yield Finding("shape", "a picture of another size", found=picture.size,
                                      expected=size, **said)  # fmt: skip
            except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
                yield Finding("damaged-picture", "a picture that cannot be decoded",
                              found=str(error), **said)  # fmt: skip
