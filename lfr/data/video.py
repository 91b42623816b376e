"""The video files of a dataset, encoded from the pictures of its episodes as they come.

AV1 by SVT-AV1 with LeRobot's own defaults (a key frame every second frame, crf 30, preset 12),
because it is the codec that is decoded wherever these datasets are looked at: rerun's native viewer
has an AV1 decoder of its own and needs a system ffmpeg for H.264; PyAV's wheels, every ffmpeg that
torchcodec accepts, and the browsers of the Hub's visualizer decode AV1 too. Its bytes are the same
each time; H.264's are with one thread only. Measured on 128 x 128: 1000 to 1800 frames per second,
the picture as good as H.264's of the same size (veryfast, 3300 frames per second).
"""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lfr.data.layout import CHUNK_SIZE, VIDEO_MEGABYTES
from lfr.data.priority import kept_priority
from lfr.data.stats import Stats, image_stats
from lfr.jobs.memory import give_back_freed_memory

if TYPE_CHECKING:
    from PIL.Image import Image

MAX_BYTES = VIDEO_MEGABYTES * 2**20  # of one file

# LeRobot's RGBEncoderConfig as options of ffmpeg; a test holds them equal. `lp` is how much SVT-AV1
# does at once. Left to itself it takes more the more cores there are, and for each the memory: a
# video of 640 x 480 takes 70 MiB with 1, 110 with 2 and 300 with 6. The bytes are the same.
CODEC, PIXELS = "libsvtav1", "yuv420p"
OPTIONS = {"g": "2", "crf": "30", "preset": "12", "svtav1-params": "fast-decode=0:lp=1"}

# SVT-AV1 divides by zero below, which ends the process (measured: widths of 16 to 24).
MIN_SIDE = 32  # pixels

# SVT-AV1 prints its settings for every file it opens unless told not to: 1 is errors only.
os.environ.setdefault("SVT_LOG", "1")


class VideoWriter:
    """Writes the episodes of one camera one after the other into as few files as fit.

    `path` is a format string with chunk_index and file_index.
    """

    def __init__(self, root: Path, key: str, path: str, fps: int) -> None:
        self.key, self._root, self._path, self._fps = key, root, path, fps
        self.shape: tuple[int, int, int] | None = None  # height, width, channels
        self._files = 0
        self._frames = 0  # in the current file
        self._file: Path | None = None
        self._container: Any = None
        self._stream: Any = None
        self._histogram = np.zeros((3, 256), np.int64)
        self._count = 0
        self._first = 0  # the episode's first frame in the current file
        self._pixels = np.zeros((3, 256), np.int64)  # histogram of the episode so far

    def write(self, images: Iterable[bytes]) -> tuple[dict[str, float | int], Stats]:
        """Encode one episode's JPEG images.

        Returns:
            Where they are, as the columns of meta/episodes, and the statistics of their pixels.

        Raises:
            ValueError: an image has another size than those before, or is too small to encode.
            OSError: an image is no image.
        """
        from PIL import Image

        self.begin()
        for data in images:
            self.add(Image.open(io.BytesIO(data)).convert("RGB"))
        return self.end()

    def begin(self) -> None:
        """Begin an episode, whose pictures are then added one by one."""
        if self._size() >= MAX_BYTES:
            self._close_file()
        self._first = self._frames
        self._pixels = np.zeros((3, 256), np.int64)

    def add(self, image: Image) -> None:
        """Encode the next picture of the episode, an RGB one; raises ValueError as `write`."""
        self._encode(np.asarray(image))
        self._pixels += np.reshape(image.histogram(), (3, 256))

    def end(self) -> tuple[dict[str, float | int], Stats]:
        """End the episode; returns as `write`."""
        count = self._frames - self._first
        self._histogram += self._pixels
        self._count += count
        where = {
            f"videos/{self.key}/chunk_index": (self._files - 1) // CHUNK_SIZE,
            f"videos/{self.key}/file_index": (self._files - 1) % CHUNK_SIZE,
            f"videos/{self.key}/from_timestamp": self._first / self._fps,
            f"videos/{self.key}/to_timestamp": self._frames / self._fps,
        }
        return where, image_stats(self._pixels, count)

    def close(self) -> None:
        self._close_file()

    @property
    def stats(self) -> Stats:
        """Statistics of all pixels of all episodes."""
        return image_stats(self._histogram, self._count)

    def feature(self) -> dict[str, Any]:
        """The feature's entry in info.json. Call it after `close`."""
        from lerobot.configs.video import RGBEncoderConfig
        from lerobot.datasets.video_utils import get_video_info

        first = self._root / self._path.format(chunk_index=0, file_index=0)
        info = get_video_info(first, video_encoder=RGBEncoderConfig())
        names = ["height", "width", "channels"]
        return {"dtype": "video", "shape": self.shape, "names": names, "info": info}

    def _encode(self, image: NDArray[np.uint8]) -> None:
        import av

        height, width, channels = image.shape
        if self.shape is None:
            if min(height, width) < MIN_SIDE:
                raise ValueError(
                    f"pictures of {width} x {height} pixels; AV1 needs {MIN_SIDE} x {MIN_SIDE}, so "
                    "record larger ones or pack without video"
                )
            self.shape = (height, width, channels)
        if image.shape != self.shape:
            raise ValueError(f"an image of {image.shape} among images of {self.shape}")
        if self._file is None:
            self._open_file()
        frame = av.VideoFrame.from_ndarray(image, format="rgb24")
        frame.pts, frame.time_base = self._frames, Fraction(1, self._fps)
        # The first frame opens the encoder.
        with contextlib.nullcontext() if self._frames else kept_priority():
            packets = self._stream.encode(frame)
        self._container.mux(packets)
        self._frames += 1

    def _open_file(self) -> None:
        import av

        assert self.shape is not None
        self._file = self._root / self._path.format(
            chunk_index=self._files // CHUNK_SIZE, file_index=self._files % CHUNK_SIZE
        )
        self._file.parent.mkdir(parents=True, exist_ok=True)
        # faststart: a browser plays it before it has loaded it
        self._container = av.open(str(self._file), "w", options={"movflags": "faststart"})
        self._stream = self._container.add_stream(CODEC, self._fps, options=dict(OPTIONS))
        self._stream.height, self._stream.width = self.shape[:2]
        self._stream.pix_fmt = PIXELS
        self._files += 1

    def _close_file(self) -> None:
        if self._container is not None:
            self._container.mux(self._stream.encode())
            self._container.close()
            self._container = self._stream = None
            give_back_freed_memory()  # of the encoder, tens of megabytes and more
        self._file = None
        self._frames = 0

    def _size(self) -> int:
        """Bytes of the current file; the encoder holds its first frames back."""
        return self._file.stat().st_size if self._file is not None and self._file.exists() else 0


def count_frames(path: Path) -> int:
    """Number of frames in a video file: one packet each."""
    import av

    container = av.open(str(path))
    with container:
        frames = sum(packet.size > 0 for packet in container.demux(video=0))
    return frames
