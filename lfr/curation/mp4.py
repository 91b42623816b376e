"""What the header of an MP4 file says of its video: frames, times, size, without reading them.

ISO/IEC 14496-12: a file is a row of boxes (size, type, content); `moov` holds the tables of
samples, `mdat` the samples. A recorder that was killed leaves no `moov`; a copy that was cut off
leaves an `mdat` that ends beyond the file.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

_CODECS = {"av01": "av1", "avc1": "h264", "avc3": "h264", "hev1": "hevc", "hvc1": "hevc",
           "vp09": "vp9", "mp4v": "mpeg4"}  # fmt: skip
_DESCRIPTION = 86  # bytes of a video's sample description before its own boxes
_HIGH_PROFILES = (100, 110, 122, 144, 244)
_CONTAINERS = (b"moov", b"trak", b"mdia", b"minf", b"stbl")


class BrokenVideoError(ValueError):
    """Not a whole MP4 file with a video in it."""


@dataclass(frozen=True)
class VideoHeader:
    """One file's video track.

    Attributes:
        width, height: pixels.
        codec: as FFmpeg calls it, e.g. `av1`, `h264`; the four characters of the file where it is
            none of the usual.
        pixels: the pixel format, as FFmpeg calls it; None where the header does not say.
        times: (F,) s, when each frame is decoded, from 0; shown then too, without B-frames.
        key_frames: (K,) indices of frames that are decoded without others.
        reordered: whether frames are shown in another order than they are stored in.
    """

    width: int
    height: int
    codec: str
    pixels: str | None
    times: NDArray[np.float64]
    key_frames: NDArray[np.int64]
    reordered: bool

    @property
    def frames(self) -> int:
        return len(self.times)


def read_header(path: Path) -> VideoHeader:
    """Read the header of an MP4 file.

    Raises:
        BrokenVideoError: it is cut off, unfinalized or no MP4, or has no video, or keeps its
            tables in fragments.
        OSError: it cannot be read.
    """
    with path.open("rb") as stream:
        size = stream.seek(0, os.SEEK_END)
        kinds, moov = [], b""
        for kind, start, end in _boxes(stream, size):
            kinds.append(kind)
            if kind == b"moov":
                stream.seek(start)
                moov = stream.read(end - start)
    if not kinds or kinds[0] != b"ftyp":
        raise BrokenVideoError("no MP4 file")
    if not moov:
        raise BrokenVideoError("unfinalized: no table of frames (moov)")
    try:
        for track in _children(moov):
            if track[0] == b"trak":
                boxes = dict(_flat(track[1]))
                if boxes.get(b"hdlr", b"")[8:12] == b"vide":
                    return _header(boxes)
    except (KeyError, struct.error, ValueError) as error:
        raise BrokenVideoError(f"a damaged table of frames: {error!r}") from error
    raise BrokenVideoError("no video in it")


def _boxes(stream: BinaryIO, size: int) -> Iterator[tuple[bytes, int, int]]:
    """Type, first byte of the content, and end of each box of a file of `size` bytes."""
    at = 0
    while at < size:
        stream.seek(at)
        head = stream.read(16)
        if len(head) < 8:
            raise BrokenVideoError(f"cut off at byte {size}")
        length, kind = struct.unpack_from(">I4s", head)
        start = at + 8
        if length == 1:  # a 64-bit length follows
            if len(head) < 16:
                raise BrokenVideoError(f"cut off at byte {size}")
            (length,) = struct.unpack_from(">Q", head, 8)
            start = at + 16
        elif length == 0:  # to the end of the file
            length = size - at
        if length < start - at:
            raise BrokenVideoError(f"a box of {length} bytes at byte {at}")
        if at + length > size:
            raise BrokenVideoError(
                f"cut off: a box {kind.decode('latin1')!r} ends at byte {at + length} of {size}"
            )
        yield kind, start, at + length
        at += length


def _children(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    at = 0
    while at + 8 <= len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        if length < 8 or at + length > len(data):
            raise ValueError(f"a box of {length} bytes")
        yield kind, data[at + 8 : at + length]
        at += length


def _flat(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    for kind, content in _children(data):
        if kind in _CONTAINERS:
            yield from _flat(content)
        else:
            yield kind, content


def _header(boxes: dict[bytes, bytes]) -> VideoHeader:
    version = boxes[b"mdhd"][0]
    (timescale,) = struct.unpack_from(">I", boxes[b"mdhd"], 20 if version else 12)
    (frames,) = struct.unpack_from(">I", boxes[b"stsz"], 8)
    if not timescale:
        raise ValueError("a time scale of 0")
    runs = _table(boxes[b"stts"], 2)
    durations = np.repeat(runs[:, 1], runs[:, 0])
    if len(durations) != frames:
        raise ValueError(f"{len(durations)} times of {frames} frames")
    if not frames:
        raise ValueError("no frames, or in fragments (moof)")
    times = np.concatenate([[0], np.cumsum(durations)[:-1]]) / timescale
    keys = _table(boxes[b"stss"], 1)[:, 0] - 1 if b"stss" in boxes else np.arange(frames)
    entry = boxes[b"stsd"][8:]  # of the first sample description
    width, height = struct.unpack_from(">HH", entry, 32)
    offsets = _table(boxes[b"ctts"], 2)[:, 1] if b"ctts" in boxes else np.zeros(1, np.int64)
    name = entry[4:8].decode("latin1")
    codec = _CODECS.get(name, name)
    return VideoHeader(
        width, height, codec, _pixels(codec, entry), times, keys, len(set(offsets.tolist())) > 1
    )


def _pixels(codec: str, entry: bytes) -> str | None:
    """The pixel format by a sample description's own box, avcC or av1C."""
    boxes = dict(_children(entry[_DESCRIPTION : struct.unpack_from(">I", entry)[0]]))
    if codec == "av1" and len(content := boxes.get(b"av1C", b"")) > 2:
        flags = content[2]
        deep, twelve, gray = flags >> 6 & 1, flags >> 5 & 1, flags >> 4 & 1
        chroma = "400" if gray else {3: "420", 2: "422", 0: "444"}.get(flags >> 2 & 3)
        bits = 12 if twelve else 10 if deep else 8
    elif codec == "h264" and len(content := boxes.get(b"avcC", b"")) > 6:
        chroma, bits = "420", 8
        if content[1] in _HIGH_PROFILES:
            at = 6  # after the sequence parameter sets come the picture parameter sets
            for _ in range(content[5] & 31):
                at += 2 + struct.unpack_from(">H", content, at)[0]
            count, at = content[at], at + 1
            for _ in range(count):
                at += 2 + struct.unpack_from(">H", content, at)[0]
            if len(content) >= at + 2:
                chroma = {0: "400", 1: "420", 2: "422", 3: "444"}[content[at] & 3]
                bits = 8 + (content[at + 1] & 7)
    else:
        return None
    if chroma is None:
        return None
    name = "gray" if chroma == "400" else f"yuv{chroma}p"
    return name if bits == 8 else f"{name}{bits}le"


def _table(content: bytes, columns: int) -> NDArray[np.int64]:
    (count,) = struct.unpack_from(">I", content, 4)
    values = np.frombuffer(content, ">u4", count * columns, 8)
    return values.astype(np.int64).reshape(count, columns)
