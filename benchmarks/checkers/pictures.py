"""A video's frames as an array, and an array as a video."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.data import video as lfr_video  # noqa: F401  (it makes SVT-AV1 silent)
from lfr.data.priority import kept_priority

OPTIONS = {
    "libsvtav1": {"g": "2", "crf": "30", "preset": "12"},  # LeRobot's own
    "libx264": {"g": "2", "crf": "23"},
}


def frames_of(file: Path) -> NDArray[np.uint8]:
    """(N, H, W, 3) frames of a video."""
    stat = file.stat()
    return _decoded(file, stat.st_ino, stat.st_mtime_ns)


@lru_cache(maxsize=2)
def _decoded(file: Path, inode: int, changed: int) -> NDArray[np.uint8]:
    import av

    with av.open(str(file)) as container:
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    decoded = np.stack(frames).astype(np.uint8, copy=False)
    decoded.flags.writeable = False
    return decoded


def encode(frames: NDArray[np.uint8], file: Path, fps: int = 20, codec: str = "libsvtav1") -> None:
    """Write (N, H, W, 3) frames as a video."""
    import av

    with kept_priority(), av.open(str(file), "w", format="mp4") as container:
        stream: Any = container.add_stream(codec, fps, options=OPTIONS[codec])
        stream.height, stream.width = frames.shape[1:3]
        stream.pix_fmt = "yuv420p"
        for frame in frames:
            picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), format="rgb24")
            container.mux(stream.encode(picture))
        container.mux(stream.encode())
