"""The encoded packets of a video: whether two episodes' pictures are, bit for bit, the same."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.curation.contents import Contents
from lfr.curation.diff.fingerprints import Hashes
from lfr.curation.diff.h264 import without_repeats
from lfr.curation.diff.side import Side
from lfr.curation.finding import Finding, Unreadable, unreadable

Rows = NDArray[np.int64]


@dataclass(frozen=True)
class Packets:
    """One file's, in the order in which they are shown.

    Attributes:
        path: the file.
        format: codec and size, e.g. `av1 128x128`.
        setup: of the codec, without which the packets cannot be decoded.
        hashes: (F,) of their bytes.
        times: (F,) when each is shown, in the file's own ticks.
        decoded: (F,) in which order they are stored and decoded.
        keys: (K,) those that are decoded without others.
    """

    path: Path
    format: str
    setup: bytes
    hashes: Hashes
    times: Rows
    decoded: Rows
    keys: Rows

    def key_before(self, frame: int) -> int:
        """The key frame from which a frame is decoded."""
        at = int(np.searchsorted(self.keys, frame, side="right")) - 1
        return int(self.keys[max(at, 0)])


def read_packets(path: Path) -> Packets:
    """Read a video's packets; none is decoded.

    Raises:
        OSError, ValueError, IndexError: it cannot be read, or has no video.
    """
    import av

    times, hashes, keys = [], [], []
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        context = stream.codec_context
        codec, extra = stream.codec.canonical_name, bytes(context.extradata or b"")
        for packet in container.demux(stream):
            if not packet.size:
                continue  # the flush at the end
            content = without_repeats(bytes(packet), extra) if codec == "h264" else bytes(packet)
            content = hashlib.blake2b(content, digest_size=8).digest()
            times.append(len(times) if packet.pts is None else packet.pts)
            hashes.append(int.from_bytes(content, "little"))
            keys.append(packet.is_keyframe)
        described = f"{context.name} {context.width}x{context.height}"
        name = f"{codec} {context.width}x{context.height}"
        setup = described.encode() + extra
    shown = np.argsort(np.array(times, np.int64), kind="stable")
    is_key = np.array(keys, bool)[shown]
    if not is_key.any():
        raise ValueError("no frames")
    return Packets(
        path, name, setup, np.array(hashes, np.uint64)[shown],
        np.array(times, np.int64)[shown], shown, np.flatnonzero(is_key),
    )  # fmt: skip


@dataclass(frozen=True)
class Stretch:
    """An episode's part of a file: `frames` from `first` on."""

    packets: Packets
    first: int
    frames: int

    @cached_property
    def fingerprint(self) -> bytes:
        """Of all packets from which its pictures are decoded, in the order in which they are."""
        packets, lead = self.packets, self.first - self.packets.key_before(self.first)
        last = packets.decoded[self.first : self.first + self.frames].max(initial=0)
        from_key = packets.decoded[self.first - lead]
        needed = (packets.decoded >= from_key) & (packets.decoded <= last)
        order = np.argsort(packets.decoded[needed])
        whole = hashlib.blake2b(packets.setup + lead.to_bytes(8, "little"), digest_size=16)
        whole.update(packets.hashes[needed][order].tobytes())
        return whole.digest()

    @property
    def keys(self) -> Hashes:
        """Hashes of its key frames."""
        keys = self.packets.keys
        inside = (keys >= self.first) & (keys < self.first + self.frames)
        return self.packets.hashes[keys[inside]]


@dataclass
class Camera:
    """A video feature of a dataset, its files read as they are asked for."""

    side: Side
    key: str
    _files: dict[str, Packets | Unreadable] = field(default_factory=dict)

    def stretch(self, position: int) -> Stretch:
        """An episode's.

        Raises:
            Unreadable: a file that is missing or broken, or ends before the episode.
        """
        name, start = self._places
        first, frames = round(start[position] * self._fps), int(self.side.length[position])
        packets = self._packets(name[position])
        if not 0 <= first <= first + frames <= len(packets.hashes):
            raise Unreadable(Finding("video-frames", "the video ends before the episode",
                                     file=name[position], found=len(packets.hashes),
                                     expected=first + frames))  # fmt: skip
        return Stretch(packets, first, frames)

    @property
    def _fps(self) -> float:
        return self._contents.fps

    @property
    def _contents(self) -> Contents:
        return self.side.contents

    @cached_property
    def _places(self) -> tuple[list[str], list[float]]:
        """Of each episode the file, and where in it it starts, in seconds."""
        prefix = f"videos/{self.key}"
        with unreadable("placement", "no place of its pictures", OverflowError, ValueError,
                        column=prefix, file="meta/episodes"):  # fmt: skip
            chunk, file = self._contents.placed(prefix)
            start = self._contents.episode_column(f"{prefix}/from_timestamp").astype(np.float64)
            if not np.isfinite(start).all() or start.ndim != 1:
                raise ValueError("no time")
        names = [
            self._contents.named("video_path", video_key=self.key, chunk_index=c, file_index=f)
            for c, f in zip(chunk.tolist(), file.tolist(), strict=True)
        ]
        return names, start.tolist()

    def _packets(self, name: str) -> Packets:
        if name not in self._files:
            self._files[name] = _read(self._contents.path, name)
        found = self._files[name]
        if isinstance(found, Unreadable):
            raise found
        return found


def _read(root: Path, name: str) -> Packets | Unreadable:
    from av.error import FFmpegError

    where: dict[str, Any] = {"file": name}
    if not (root / name).is_file():
        return Unreadable(Finding("missing-file", "a video that is not there", **where))
    try:
        with unreadable("damaged-file", "a video that cannot be read", FFmpegError, OSError,
                        ValueError, IndexError, **where):  # fmt: skip
            return read_packets(root / name)
    except Unreadable as error:
        return error
