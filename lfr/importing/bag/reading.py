"""The messages of a bag one after the other, in the order in which they were written.

That order needs no more memory than one chunk, however the times of the messages lie; it does not
depend on the summary either, which a recorder that was killed has not written.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from lfr.data.mcap_file import DAMAGE, MAGIC
from lfr.errors import DataError
from lfr.importing.bag.decoding import Decoders, MessageError
from lfr.importing.bag.files import Bag

MOST_CHUNK = 2**30  # bytes of a chunk's messages


@dataclass
class Source:
    """A channel of one file: what its messages are.

    `type` is the schema's name, `encoding` that of the messages.
    """

    file: Path
    topic: str
    type: str
    encoding: str
    _schema: Schema | None
    _decoders: Decoders
    _decode: Callable[[bytes], Any] | None = field(default=None, init=False)

    def decode(self, data: bytes) -> Any:
        """A message's content.

        Raises:
            MessageError: it cannot be decoded, or no message of this kind can.
        """
        if self._decode is None:
            self._decode = self._decoders.of(self.encoding, self._schema)
        return self._decode(data)

    @property
    def header_first(self) -> bool:
        """Whether a message begins with a std_msgs/Header, in CDR."""
        return self.encoding == "cdr" and Decoders.header_first(self._schema)


def read_messages(
    bag: Bag, topics: Collection[str] | None = None, notes: list[str] | None = None
) -> Iterator[tuple[Source, Message]]:
    """The messages of these topics, or of all.

    Args:
        notes: is given a line for each file that was cut off, whose whole messages are read.

    Raises:
        DataError: a file is no MCAP file, or damaged before its end.
    """
    for file in bag.files:
        yield from _FileReader(file, topics, notes if notes is not None else []).messages()


class _FileReader:
    def __init__(self, file: Path, topics: Collection[str] | None, notes: list[str]) -> None:
        self._file, self._topics, self._notes = file, topics, notes
        self._decoders = Decoders()  # by the ids of this file's schemas
        self._schemas: dict[int, Schema] = {}
        self._sources: dict[int, Source] = {}

    def messages(self) -> Iterator[tuple[Source, Message]]:
        for record in self._records():
            if isinstance(record, Message):
                source = self._sources.get(record.channel_id)
                if source is None:
                    raise self._damaged("a message of a channel that is not there")
                if self._topics is None or source.topic in self._topics:
                    yield source, record
            elif isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Channel) and record.id not in self._sources:
                schema = self._schemas.get(record.schema_id)
                self._sources[record.id] = Source(
                    self._file, record.topic, schema.name if schema else "",
                    record.message_encoding, schema, self._decoders,
                )  # fmt: skip

    def _records(self) -> Iterator[McapRecord]:
        size = self._file.stat().st_size
        with self._file.open("rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                raise DataError("not an MCAP file", file=self._file, found=f"{size} bytes")
            reader = StreamReader(stream, skip_magic=True, emit_chunks=True, record_size_limit=size)
            records, whole = reader.records, stream.tell()
            while True:
                try:
                    record = next(records)
                except StopIteration:
                    return
                except DAMAGE as error:
                    stream.seek(-len(MAGIC), 2)
                    if stream.read() == MAGIC:  # the end is there, so it is not cut off
                        raise self._damaged(error) from error
                    self._notes.append(f"{self._file}: cut off; read as far as it is whole, "
                                       f"{size - whole} bytes at its end are lost")  # fmt: skip
                    return
                whole = stream.tell()
                yield from self._parts(record)

    def _parts(self, record: McapRecord) -> list[McapRecord]:
        if not isinstance(record, Chunk):
            return [record]
        if record.uncompressed_size > MOST_CHUNK:
            raise DataError("a chunk too large to read", file=self._file,
                            found=f"{record.uncompressed_size} bytes",
                            expected=f"at most {MOST_CHUNK}")  # fmt: skip
        try:
            return breakup_chunk(record, validate_crc=True)
        except DAMAGE as error:
            raise self._damaged(error) from error

    def _damaged(self, error: object) -> DataError:
        return DataError(
            f"a damaged MCAP file; `lfr recover {self._file}` copies what is whole",
            file=self._file, found=error,
        )  # fmt: skip


__all__ = ["MessageError", "Source", "read_messages"]
