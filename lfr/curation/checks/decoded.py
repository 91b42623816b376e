"""The pictures of a dataset's videos, decoded, and what is kept of each episode's."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.curation.contents import Contents, Runs
from lfr.curation.finding import Finding

SIZE, COARSE = 48, 12  # pixels of the small pictures that are compared, and of coarse ones
CROP = 192  # pixels of the middle, whose finest detail is measured
COMPARED = 8  # pictures at an episode's beginning that are compared with other episodes'

Picture = NDArray[np.float32]


@dataclass
class Seen:
    """What an episode's decoded pictures come to.

    Attributes:
        rows: (F,) of the dataset, of each picture.
        mean, spread: (F,) of its brightness, white is 1.
        detail: (F,) its finest.
        change: (F,) how far it is from the picture before; 0 for the first.
        coarse: (F, COARSE^2) its brightness.
        first: the small pictures of its beginning.
        total: (SIZE, SIZE, 3), the sum of its small pictures.
    """

    rows: list[int] = field(default_factory=list)
    mean: list[float] = field(default_factory=list)
    spread: list[float] = field(default_factory=list)
    detail: list[float] = field(default_factory=list)
    change: list[float] = field(default_factory=list)
    coarse: list[Picture] = field(default_factory=list)
    first: list[Picture] = field(default_factory=list)
    total: Any = 0.0
    _last: Picture | None = None

    def add(self, row: int, frame: Any) -> None:
        """Take in the picture of a row: an `av.VideoFrame`."""
        small = frame.reformat(SIZE, SIZE, "rgb24", interpolation="AREA").to_ndarray()
        small = small.astype(np.float32) / 255
        self.rows.append(row)
        self.mean.append(float(small.mean()))
        self.spread.append(float(small.std()))
        self.detail.append(_detail(frame.to_ndarray(format="gray")))
        self.change.append(0.0 if self._last is None else float(np.abs(small - self._last).mean()))
        part = SIZE // COARSE
        blocks = small.mean(axis=-1).reshape(COARSE, part, COARSE, part)
        self.coarse.append(blocks.mean(axis=(1, 3)).ravel())
        if len(self.first) < COMPARED:
            self.first.append(small)
        self.total = self.total + small
        self._last = small

    @cached_property
    def picture(self) -> Picture:
        """The mean picture."""
        return self.total / len(self.rows)


def decode(
    contents: Contents, key: str, there: Runs, stride: int, seen: dict[int, Seen]
) -> Iterator[Finding]:
    """Fill ``seen`` by the places of the episodes; findings are of files that do not decode."""
    import av
    from av.error import FFmpegError

    start = contents.episode_column(f"videos/{key}/from_timestamp")
    for name, of_file in contents.placed_in(f"videos/{key}").items():
        of_file = of_file[of_file < len(there.start)]
        frames = np.rint(start[of_file] * contents.fps).astype(int)
        ends = frames + there.length[of_file]
        where: dict[str, Any] = {"file": name, "column": key}
        expected = int(ends.max()) if len(of_file) else 0
        decoded = 0
        try:
            with av.open(str(contents.path / name)) as container:
                stream = container.streams.video[0]
                stream.thread_type = "AUTO"
                # strict: a damaged frame is an error, not one that is made up
                stream.codec_context.options = {"err_detect": "explode"}
                for frame in container.decode(stream):
                    at = decoded
                    decoded += 1
                    inside = np.flatnonzero((frames <= at) & (at < ends))
                    if frame.is_corrupt:
                        yield Finding("damaged-picture", "a frame that is damaged", **where,
                                      found=f"frame {at}",
                                      episodes=_values(there, of_file[inside]))  # fmt: skip
                    if not len(inside):
                        continue
                    episode = int(of_file[inside[0]])
                    offset = at - int(frames[inside[0]])
                    if offset % stride == 0:
                        row = int(there.start[episode]) + offset
                        seen.setdefault(episode, Seen()).add(row, frame)
        except (FFmpegError, OSError, IndexError) as error:
            yield Finding("damaged-picture", "a video that cannot be decoded", **where,
                          found=f"{type(error).__name__} after frame {decoded - 1}",
                          episodes=_values(there, of_file[ends > decoded]))  # fmt: skip
            continue
        if decoded < expected:
            yield Finding("damaged-picture", "frames that cannot be decoded", **where,
                          found=decoded, expected=expected,
                          episodes=_values(there, of_file[ends > decoded]))  # fmt: skip


def _values(there: Runs, places: NDArray) -> tuple[int, ...]:
    return tuple(np.unique(there.episode[places]).tolist())


def _detail(gray: NDArray[np.uint8]) -> float:
    """The mean of a Laplacian over the middle of a picture, white is 1."""
    height, width = gray.shape
    top, left = max((height - CROP) // 2, 0), max((width - CROP) // 2, 0)
    g = gray[top : top + CROP, left : left + CROP].astype(np.float32) / 255
    around = g[:-2, 1:-1] + g[2:, 1:-1] + g[1:-1, :-2] + g[1:-1, 2:]
    return float(np.abs(4 * g[1:-1, 1:-1] - around).mean())
