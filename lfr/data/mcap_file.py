"""MCAP files as containers: whole or cut off, their counts, and their summary in a fixed order."""

from __future__ import annotations

import io
import os
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import groupby
from pathlib import Path
from typing import BinaryIO

from mcap.exceptions import McapError
from mcap.reader import McapReader, make_reader
from zstandard import ZstdError

from lfr.errors import DataError

DAMAGE = (McapError, ZstdError, RuntimeError, struct.error, ValueError, EOFError, MemoryError,
          KeyError, OverflowError)  # fmt: skip
"""What reading a damaged file raises: its checksums; RuntimeError the lz4 library; KeyError a
message of a channel or schema that is not there; the rest, lengths and text without a checksum."""

MAGIC = b"\x89MCAP0\r\n"
_SCHEMA, _CHANNEL = 0x03, 0x04
_DATA_END = struct.Struct("<BQI")  # opcode, length, CRC of all before it
_FOOTER = struct.Struct("<BQQQI")  # opcode, length, summary start, summary offset start, CRC


@contextmanager
def open_whole(path: Path) -> Iterator[McapReader]:
    """A reader of a finished MCAP file, every byte of which its checksums cover.

    Raises:
        DataError: the file is missing, no MCAP, cut off or damaged, also while it is being read.
    """
    if not path.is_file():
        raise DataError("no such log; record it first", file=path)
    data = path.read_bytes()
    if data[: len(MAGIC)] != MAGIC:
        start = data[: len(MAGIC)]
        raise DataError(
            "not an MCAP file", file=path, found=f"first bytes {start!r}", expected=MAGIC
        )
    if data[-len(MAGIC) :] != MAGIC or len(data) < 2 * len(MAGIC) + _FOOTER.size:
        raise DataError(
            "cut-off MCAP file; record the episode again",
            file=path,
            found=f"{len(data)} bytes ending in {data[-len(MAGIC) :]!r}",
            expected=f"an end of {MAGIC!r}",
        )
    try:
        check_sums(io.BytesIO(data))
        yield make_reader(io.BytesIO(data), validate_crcs=True)
    except DAMAGE as error:
        raise DataError(
            "damaged MCAP file; record the episode again",
            file=path,
            found=f"{type(error).__name__}: {error}",
            expected="records as its checksums say",
        ) from error


def check_sums(stream: BinaryIO) -> None:
    """The readers of the `mcap` package check a chunk's messages only, not metadata or summary.

    Args:
        stream: a file with an end, which may be larger than the memory.

    Raises:
        ValueError: the data section or the summary is not what its CRC says (0 is no CRC).
        struct.error: the file is too short for an end.
    """
    size = stream.seek(0, os.SEEK_END)
    footer_at = size - len(MAGIC) - _FOOTER.size
    _, _, summary_at, _, summary_crc = _FOOTER.unpack(
        _read(stream, max(footer_at, 0), _FOOTER.size)
    )
    end_at = (summary_at or footer_at) - _DATA_END.size
    if not len(MAGIC) <= end_at <= footer_at:
        raise ValueError(f"a summary at byte {summary_at}")
    opcode, length, data_crc = _DATA_END.unpack(_read(stream, end_at, _DATA_END.size))
    if (opcode, length) != (0x0F, 4):
        raise ValueError("no end of the data before the summary")
    if data_crc and crc(stream, 0, end_at) != data_crc:
        raise ValueError("the data's CRC differs")
    if summary_crc and crc(stream, end_at + _DATA_END.size, size - len(MAGIC) - 4) != summary_crc:
        raise ValueError("the summary's CRC differs")


def _read(stream: BinaryIO, at: int, size: int) -> bytes:
    stream.seek(at)
    return stream.read(size)


def crc(stream: BinaryIO, start: int, end: int) -> int:
    """CRC-32 of the bytes from `start` to before `end`."""
    stream.seek(start)
    found = 0
    while part := stream.read(min(end - start, 2**20)):
        found, start = zlib.crc32(part, found), start + len(part)
    return found


def message_counts(path: Path) -> dict[str, int]:
    """Number of messages on each topic, from the summary. Raises DataError as `open_whole`."""
    with open_whole(path) as reader:
        summary = reader.get_summary()
        if summary is None or summary.statistics is None:
            return {}
        counts = summary.statistics.channel_message_counts
        return {channel.topic: counts.get(id, 0) for id, channel in summary.channels.items()}


def settle(path: Path) -> None:
    """Put the summary's schemas and channels in the order of their ids, and sync the file.

    foxglove-sdk 0.25 writes them in the order of a hash table, so the same messages gave another
    file each time. The groups keep their sizes, so no offset changes, only the summary's CRC.

    Raises:
        DataError: the file has no footer where one must be.
    """
    with path.open("r+b") as stream:
        end = stream.seek(0, os.SEEK_END)
        footer_at = end - len(MAGIC) - _FOOTER.size
        if footer_at < len(MAGIC):
            raise DataError("cut-off MCAP file", file=path, found=f"{end} bytes")
        stream.seek(footer_at)
        opcode, length, summary_at, offsets_at, _ = _FOOTER.unpack(stream.read(_FOOTER.size))
        if opcode != 0x02 or not len(MAGIC) <= summary_at <= offsets_at <= footer_at:
            raise DataError("cut-off MCAP file", file=path, found=f"opcode {opcode}")
        stream.seek(summary_at)
        summary, offsets = stream.read(offsets_at - summary_at), stream.read(footer_at - offsets_at)

        settled = b"".join(
            record
            for opcode, group in groupby(_records(summary), key=lambda record: record[0])
            for record in (sorted(group, key=_id) if opcode in (_SCHEMA, _CHANNEL) else group)
        )
        # the CRC covers the summary, its offsets, and the footer up to the CRC itself
        footer = _FOOTER.pack(0x02, length, summary_at, offsets_at, 0)[:-4]
        crc = zlib.crc32(settled + offsets + footer)
        stream.seek(summary_at)
        stream.write(settled + offsets + footer + struct.pack("<I", crc) + MAGIC)
        stream.flush()
        os.fsync(stream.fileno())


def _records(data: bytes) -> Iterator[bytes]:
    at = 0
    while at < len(data):
        (length,) = struct.unpack_from("<Q", data, at + 1)
        yield data[at : at + 9 + length]
        at += 9 + length


def _id(record: bytes) -> int:
    return struct.unpack_from("<H", record, 9)[0]
