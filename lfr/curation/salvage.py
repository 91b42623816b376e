"""The whole records of an MCAP file, whole or not."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from mcap.records import (
    Attachment,
    Channel,
    Chunk,
    DataEnd,
    Header,
    McapRecord,
    Message,
    Metadata,
    Schema,
)
from mcap.stream_reader import StreamReader, breakup_chunk

from lfr.data.mcap_file import DAMAGE, MAGIC, crc
from lfr.errors import DataError


@dataclass
class Salvage:
    """The whole records of a file, in their order.

    `damaged` counts chunks that are there but not what their checksum says, `unread` is the number
    of bytes after the last whole record, `finished` whether the file's end is there, `suspect`
    whether its checksum says that something outside the chunks, as metadata is, has changed. A
    message whose channel or schema is lost, with the chunk that held it and with the summary, is
    not among the messages: `nameless` counts these, and `lost_topics` are those of which the
    channel is known.
    """

    profile: str = ""
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    messages: list[Message] = field(default_factory=list)
    metadata: list[Metadata] = field(default_factory=list)
    attachments: list[Attachment] = field(default_factory=list)
    damaged: int = 0
    unread: int = 0
    finished: bool = False
    suspect: bool = False
    nameless: int = 0
    lost_topics: tuple[str, ...] = ()

    def record(self, name: str) -> dict[str, str] | None:
        found = (dict(m.metadata) for m in self.metadata if m.name == name)
        return next(found, None)


def salvage(log: Path, take: Callable[[Message], object] | None = None) -> Salvage:
    """Every whole record of a file, whole or not.

    Args:
        take: is given each message of a whole record; then none is kept, so that a file may be
            larger than the memory.

    Raises:
        DataError: there is no such file, or it is no MCAP file.
    """
    if not log.is_file():
        raise DataError("no such log", file=log)
    saved, counts = Salvage(), Counter[int]()
    keep = take or saved.messages.append
    with log.open("rb") as stream:
        if stream.read(len(MAGIC)) != MAGIC:
            raise DataError("not an MCAP file", file=log)
        good = stream.tell()
        size = log.stat().st_size
        reader = StreamReader(stream, skip_magic=True, emit_chunks=True, record_size_limit=size)  # pyright: ignore[reportArgumentType]
        records = reader.records
        while True:
            try:
                record = next(records)
            except StopIteration:
                saved.finished = True
                break
            except DAMAGE:
                break
            if isinstance(record, DataEnd) and record.data_section_crc and not saved.damaged:
                with log.open("rb") as whole:
                    saved.suspect = crc(whole, 0, good) != record.data_section_crc
            good = stream.tell()
            for part in _parts(record, saved):
                if isinstance(part, Message):
                    counts[part.channel_id] += 1
                    keep(part)
                else:
                    _keep(part, saved)
        saved.unread = 0 if saved.finished else size - good
    _settle(saved, counts)
    return saved


def _settle(saved: Salvage, counts: Counter[int]) -> None:
    """Keep the messages of which it is known what they are, as the summary may have said last."""
    known = {
        id
        for id, channel in saved.channels.items()
        if channel.schema_id == 0 or channel.schema_id in saved.schemas
    }
    if lost := counts.keys() - known:
        saved.messages = [message for message in saved.messages if message.channel_id in known]
        saved.nameless = sum(counts[id] for id in lost)
        ids = lost & saved.channels.keys()
        saved.lost_topics = tuple(sorted(saved.channels[id].topic for id in ids))


def _parts(record: McapRecord, saved: Salvage) -> Iterable[McapRecord]:
    if not isinstance(record, Chunk):
        return [record]
    try:
        return breakup_chunk(record, validate_crc=True)
    except DAMAGE:
        saved.damaged += 1
        return []


def _keep(record: McapRecord, saved: Salvage) -> None:
    match record:
        case Header():
            saved.profile = record.profile
        case Schema():
            saved.schemas.setdefault(record.id, record)
        case Channel():
            saved.channels.setdefault(record.id, record)
        case Metadata():
            saved.metadata.append(record)
        case Attachment():
            saved.attachments.append(record)
