"""The whole records of an MCAP file, whole or not."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from mcap.exceptions import McapError
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
from zstandard import ZstdError

from lfr.data.mcap_file import MAGIC
from lfr.errors import DataError

# RuntimeError: of the lz4 library, whose logs others write
_DAMAGE = (McapError, ZstdError, RuntimeError, struct.error, ValueError, EOFError, MemoryError,
           KeyError)  # fmt: skip


@dataclass
class Salvage:
    """The whole records of a file, in their order.

    `damaged` counts chunks that are there but not what their checksum says, `unread` is the number
    of bytes after the last whole record, `finished` whether the file's end is there, `suspect`
    whether its checksum says that something outside the chunks, as metadata is, has changed.
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

    def record(self, name: str) -> dict[str, str] | None:
        found = (dict(m.metadata) for m in self.metadata if m.name == name)
        return next(found, None)


def salvage(log: Path) -> Salvage:
    """Every whole record of a file, whole or not.

    Raises:
        DataError: there is no such file, or it is no MCAP file.
    """
    if not log.is_file():
        raise DataError("no such log", file=log)
    saved = Salvage()
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
            except _DAMAGE:
                break
            if isinstance(record, DataEnd) and record.data_section_crc and not saved.damaged:
                saved.suspect = _crc(log, good) != record.data_section_crc
            good = stream.tell()
            for part in _parts(record, saved):
                _keep(part, saved)
        saved.unread = 0 if saved.finished else size - good
    return saved


def _crc(log: Path, size: int) -> int:
    return zlib.crc32(memoryview(log.read_bytes())[:size])


def _parts(record: McapRecord, saved: Salvage) -> Iterable[McapRecord]:
    if not isinstance(record, Chunk):
        return [record]
    try:
        return breakup_chunk(record, validate_crc=True)
    except _DAMAGE:
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
        case Message() if record.channel_id in saved.channels:
            saved.messages.append(record)
        case Metadata():
            saved.metadata.append(record)
        case Attachment():
            saved.attachments.append(record)
