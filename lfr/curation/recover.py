"""A cut-off MCAP file made readable again: what its writer had flushed, and what was lost.

A killed recorder leaves whole chunks, the last of them at most 20 frames old, without the summary
that readers look for. The records that are whole are copied into a new file. A log of this project
is cut where its first frame is incomplete and given an `outcome`, so that it reads as any other.
"""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from mcap.records import Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from lfr.artifacts import parse_json, write_whole
from lfr.curation.salvage import Salvage, salvage
from lfr.data import messages
from lfr.data.log_reader import ALWAYS, PER_FRAME, read_log
from lfr.data.mcap_file import open_whole
from lfr.errors import DataError


@dataclass(frozen=True)
class Recovery:
    """What became of a file.

    Attributes:
        source, mended: the cut-off file and the readable one beside it; None where the file is
            whole and nothing was written.
        messages: of the mended file; dropped: whole messages of frames that are incomplete or
            come after a gap.
        frames: complete ones, of a log of this project; None for any other MCAP file.
        seconds: of time that the mended file spans.
        expected_frames: what the log's outcome says, where that was saved.
        outcome_missing: whether the recorder's own word on the outcome is lost.
        damaged, unread: chunks with a wrong checksum; bytes after the last whole record.
        suspect: whether metadata, which has no checksum of its own, may have changed.
        nameless: messages dropped since it is lost what they are; lost_topics: their topics, as
            far as these are known.
    """

    source: Path
    mended: Path | None
    messages: int = 0
    dropped: int = 0
    frames: int | None = None
    seconds: float = 0.0
    expected_frames: int | None = None
    outcome_missing: bool = False
    damaged: int = 0
    unread: int = 0
    suspect: bool = False
    nameless: int = 0
    lost_topics: tuple[str, ...] = ()

    def __str__(self) -> str:
        if self.mended is None:
            return f"{self.source}: whole, nothing to mend"
        kept = f"{self.messages} messages" if self.frames is None else f"{self.frames} frames"
        lines = [f"{self.mended}: {kept}, {self.seconds:g} s"]
        if self.expected_frames is not None and self.frames is not None:
            lines.append(f"lost: {self.expected_frames - self.frames} frames of "
                         f"{self.expected_frames}")  # fmt: skip
        elif self.frames is not None:
            lines.append("lost: all that was not yet on the disk, a second at most where the "
                         "recorder was killed")  # fmt: skip
        if self.dropped:
            lines.append(f"lost: {self.dropped} messages of incomplete frames, or after a gap")
        if self.damaged:
            lines.append(f"lost: {self.damaged} damaged chunks")
        if self.nameless:
            of = f" of {', '.join(self.lost_topics)}" if self.lost_topics else ""
            lines.append(f"lost: {self.nameless} messages{of}, whose schema or channel is lost")
        if self.unread:
            lines.append(f"lost: {self.unread} bytes after the last whole record")
        if self.suspect:
            lines.append("mind: the file's checksum differs; its metadata may have changed")
        if self.outcome_missing:
            lines.append("lost: the outcome; success is what the last frames show")
        return "\n".join(lines)


def recover(log: Path) -> Recovery:
    """Mend a cut-off MCAP file into `<name>.recovered.mcap` beside it.

    Raises:
        DataError: it is no MCAP file, holds no whole message, or was recovered before.
    """
    log = Path(log)
    count: int | None = None
    # an error is of what is cut off or damaged, or there is none, which salvage says
    with suppress(DataError), open_whole(log) as reader:
        count = sum(1 for _ in reader.iter_messages(log_time_order=False))
    saved = salvage(log)
    if count is not None and not (saved.damaged or saved.nameless):
        return Recovery(log, None, count)
    if not saved.messages:
        of = f" of {', '.join(saved.lost_topics)}" if saved.lost_topics else ""
        found = f"{saved.nameless} messages{of}, whose schema is lost" if saved.nameless else None
        raise DataError("nothing to recover: no whole message", file=log, found=found)
    mended = log.with_name(log.name.removesuffix(".partial").removesuffix(".mcap")
                           + ".recovered.mcap")  # fmt: skip
    if mended.exists():
        raise DataError("recovered before; remove it to do it again", file=mended)
    ours = saved.record("episode") is not None and saved.record("features") is not None
    said: int | None = None
    outcome = (saved.record("outcome") if ours else None) or {}
    with suppress(ValueError):
        said = parse_json(outcome.get("frames", "null"))
    kept, frames = _whole_frames(saved) if ours else (saved.messages, None)
    if frames == 0:
        raise DataError("nothing to recover: no whole frame", file=log)
    metadata = list(saved.metadata)
    if frames is not None and frames != said:
        metadata = [m for m in metadata if m.name != "outcome"]
        metadata.append(Metadata(name="outcome", metadata=_outcome(saved, kept, frames)))
    with write_whole(mended) as partial:
        _write(partial, saved, kept, metadata)
        if frames is not None:
            read_log(partial)  # or there is no mended log
    times = [message.log_time for message in kept]
    return Recovery(
        log, mended, len(kept), len(saved.messages) - len(kept), frames,
        (max(times) - min(times)) / 1e9, said, ours and said is None, saved.damaged, saved.unread,
        saved.suspect, saved.nameless, saved.lost_topics,
    )  # fmt: skip


def _whole_frames(saved: Salvage) -> tuple[list[Message], int]:
    """The messages of the frames before the first incomplete one, and how many frames those are.

    The state after the last action is the next frame's, so that one frame is given up for it
    unless the recorder had finished.
    """
    times: dict[str, set[int]] = defaultdict(set)
    for message in saved.messages:
        times[_topic(saved, message)].add(message.log_time)
    needed = [topic for topic in times if _per_frame(topic)]
    if not set(ALWAYS) <= set(needed):
        return [], 0
    states = sorted(times[messages.SIMULATOR_STATE])
    whole = set.intersection(*(times[topic] for topic in needed))
    frames = 0
    step = min((b - a for a, b in pairwise(states)), default=0)
    for at, following in pairwise(states):
        if at not in whole or following - at != step:
            break
        frames += 1
    if not frames:
        return [], 0
    end = states[frames]  # when the last action has been done
    after = (messages.SIMULATOR_STATE, messages.TRANSFORMS)
    kept = [
        message
        for message in saved.messages
        if message.log_time < end or (message.log_time == end and _topic(saved, message) in after)
    ]
    return kept, frames


def _per_frame(topic: str) -> bool:
    camera = topic.startswith(messages.CAMERA) and not topic.endswith(messages.CALIBRATION)
    return camera or topic in (*PER_FRAME, messages.EXECUTED_ACTION)


def _topic(saved: Salvage, message: Message) -> str:
    return saved.channels[message.channel_id].topic


def _outcome(saved: Salvage, kept: list[Message], frames: int) -> dict[str, str]:
    """What the recorder would have written, from the frames that are left, and that it did not."""
    success = any(
        messages.message_class(schema.name, schema.data).FromString(message.data).success  # pyright: ignore[reportAttributeAccessIssue]
        for message, schema in _successes(saved, kept)
    )
    content = {"frames": frames, "success": success, "recovered": True}
    return {key: json.dumps(value) for key, value in content.items()}


def _successes(saved: Salvage, kept: list[Message]) -> Iterator[tuple[Message, Schema]]:
    for message in kept:
        channel = saved.channels[message.channel_id]
        if channel.topic == messages.SUCCESS:
            yield message, saved.schemas[channel.schema_id]


def _write(path: Path, saved: Salvage, kept: list[Message], metadata: list[Metadata]) -> None:
    used = Counter(message.channel_id for message in kept)
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD)
        writer.start(saved.profile, library="lfr recover")
        ids: dict[int, int] = {}
        schemas: dict[int, int] = {0: 0}  # 0: none
        for id, channel in saved.channels.items():
            if not used[id]:
                continue
            if channel.schema_id not in schemas:
                schema = saved.schemas[channel.schema_id]
                schemas[channel.schema_id] = writer.register_schema(
                    schema.name, schema.encoding, schema.data
                )
            ids[id] = writer.register_channel(
                channel.topic, channel.message_encoding, schemas[channel.schema_id],
                channel.metadata,
            )  # fmt: skip
        for record in metadata:
            writer.add_metadata(record.name, dict(record.metadata))
        for a in saved.attachments:
            writer.add_attachment(a.create_time, a.log_time, a.name, a.media_type, a.data)
        for m in kept:
            writer.add_message(ids[m.channel_id], m.log_time, m.data, m.publish_time, m.sequence)
        writer.finish()
