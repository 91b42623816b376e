"""Frames out of a dataset's videos."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lfr.errors import DataError

if TYPE_CHECKING:
    from av import VideoFrame


def frames(file: Path, numbers: Sequence[int], key: str) -> Iterator[VideoFrame]:
    """The frames of these numbers, which rise, from the file's first, which is 0.

    Decoding begins at the key frame before the first of them.

    Args:
        key: the feature, for messages.

    Raises:
        DataError: the video is missing, does not play, or ends before.
    """
    import av
    from av.error import FFmpegError

    if not file.is_file():
        raise DataError("the video is missing", file=file, column=key)
    found = 0
    try:
        with av.open(str(file)) as container:
            stream = container.streams.video[0]
            rate, base = stream.average_rate, stream.time_base
            if rate is None or base is None:
                raise DataError("the video says no rate", file=file, column=key)
            if numbers[0]:
                container.seek(int(numbers[0] / rate / base), stream=stream)
            for frame in container.decode(stream):
                if frame.pts is None or round(frame.pts * base * rate) < numbers[found]:
                    continue
                yield frame
                found += 1
                if found == len(numbers):
                    return
    except (FFmpegError, OSError, IndexError) as error:
        raise DataError("a video that does not play", file=file, column=key,
                        found=str(error).splitlines()[0]) from error  # fmt: skip
    raise DataError("the video is cut off", file=file, column=key, found=f"{found} frames",
                    expected=f"{len(numbers)}, the last number {numbers[-1]}")  # fmt: skip
