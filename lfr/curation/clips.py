"""Parts of a dataset's videos as files of their own, decoded again only where they must be.

A stretch of episodes that is a whole file is copied; one that starts at a key frame is copied
packet by packet, its pictures bit for bit the same; only one that starts between two key frames is
decoded and encoded again, with the settings that info.json keeps.
"""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal

from lfr.curation.mp4 import BrokenVideoError, read_header
from lfr.data.priority import kept_priority
from lfr.errors import DataError


@dataclass(frozen=True)
class Clip:
    """Frames `first` to `first + frames - 1` of a video file."""

    source: Path
    first: int
    frames: int

    def followed_by(self, other: Clip) -> bool:
        return self.source == other.source and self.first + self.frames == other.first

    def joined(self, other: Clip) -> Clip:
        return Clip(self.source, self.first, self.frames + other.frames)


def write_clip(
    clip: Clip, path: Path, fps: float, info: dict[str, Any] | None
) -> Literal["copied", "cut", "encoded"]:
    """Write a clip to `path`, an MP4 file; says how.

    Args:
        fps: frames per second.
        info: the feature's `info` in info.json, from which an encoder is set up.

    Raises:
        DataError: the source is broken or too short, or what was written is.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        header = read_header(clip.source)
    except (BrokenVideoError, OSError) as error:
        raise DataError("a video that does not play", file=clip.source, found=error) from error
    end = clip.first + clip.frames
    if end > header.frames:
        raise DataError("the video ends before the episode", file=clip.source, found=header.frames,
                        expected=end)  # fmt: skip
    how: Literal["copied", "cut", "encoded"] = "encoded"
    if clip.frames == header.frames:
        shutil.copyfile(clip.source, path)
        return "copied"
    if clip.first in header.key_frames and (end == header.frames or not header.reordered):
        _cut(clip, path, fps)
        how = "cut"
    else:
        _encode(clip, path, fps, info)
    written = read_header(path).frames
    if written != clip.frames:
        raise DataError("a video was not written whole", file=path, found=written,
                        expected=clip.frames)  # fmt: skip
    return how


def _cut(clip: Clip, path: Path, fps: float) -> None:
    import av

    with (
        av.open(str(clip.source)) as source,
        av.open(str(path), "w", options={"movflags": "faststart"}) as out,
    ):
        stream = source.streams.video[0]
        copy = out.add_stream_from_template(stream, opaque=True)
        base = stream.time_base or Fraction(1)
        start = round(clip.first / fps / base)
        source.seek(start, stream=stream)
        for packet in source.demux(stream):
            if packet.pts is None or packet.dts is None:
                continue  # the flush at the end
            frame = round(packet.pts * base * fps)
            if frame >= clip.first + clip.frames:
                break
            if frame >= clip.first:
                packet.pts, packet.dts = packet.pts - start, packet.dts - start
                packet.stream = copy
                out.mux(packet)


def _encode(clip: Clip, path: Path, fps: float, info: dict[str, Any] | None) -> None:
    import av
    from av.video.frame import PictureType
    from lerobot.configs import encoder_config_from_video_info

    os.environ.setdefault("SVT_LOG", "1")  # SVT-AV1 prints its settings otherwise: errors only

    encoder = encoder_config_from_video_info(info)
    rate = Fraction(fps).limit_denominator(1001)
    with (
        av.open(str(clip.source)) as source,
        av.open(str(path), "w", options={"movflags": "faststart"}) as out,
    ):
        options = dict(encoder.get_codec_options(as_strings=True))
        stream: Any = out.add_stream(encoder.vcodec, rate, options=options)
        read = source.streams.video[0]
        stream.width, stream.height = read.width, read.height
        stream.pix_fmt = encoder.pix_fmt
        for number, frame in enumerate(_frames(source, read, clip, fps)):
            frame.pts, frame.time_base = number, 1 / rate
            frame.pict_type = PictureType.NONE  # the encoder is to decide
            # The first frame opens the encoder.
            with contextlib.nullcontext() if number else kept_priority():
                packets = stream.encode(frame)
            out.mux(packets)
        out.mux(stream.encode())


def _frames(source: Any, stream: Any, clip: Clip, fps: float) -> Iterable[Any]:
    base = stream.time_base or Fraction(1)
    source.seek(int(clip.first / fps / base), stream=stream)  # to the key frame before
    for frame in source.decode(stream):
        number = round(frame.pts * base * fps)
        if number >= clip.first + clip.frames:
            return
        if number >= clip.first:
            yield frame
