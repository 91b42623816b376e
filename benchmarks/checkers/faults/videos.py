"""Faults of the videos: of what is said of them, and of what they show."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.checkers.dataset_copy import DatasetCopy
from benchmarks.checkers.faults.fault import ROW, Fault, K, Plant
from benchmarks.checkers.faults.meta import FILE, feature, of_episode

SPAN = "video|timestamp|span|window|segment|footage"
FRAMES = f"{SPAN}|frames|desync|end"
SIZE = "shape|resolution|size|width|height"
STILL = "frozen|freeze|identical|static|stuck|duplicate|repeat|stay"
NOTHING = "black|dark|exposure|clipped|degenerate|constant|flat|pixel|blank"

Edit = Callable[[NDArray[np.uint8]], NDArray[np.uint8]]
"""Other frames in place of an episode's."""


def _shown(edit: Edit, *, described: bool = True) -> Plant:
    """An episode that shows something else, with statistics of what it shows."""

    def plant(copy: DatasetCopy) -> None:
        frames, span = copy.frames().copy(), copy.span(K)
        frames[span] = edit(frames[span].copy())
        copy.film(frames)
        if described:
            copy.restat_pictures({K: frames[span]})

    return plant


def _still(first: int, last: int | None = None) -> Edit:
    def edit(frames: NDArray[np.uint8]) -> NDArray[np.uint8]:
        frames[0 if last is None else first : last] = frames[first]
        return frames

    return edit


def _late(frames: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.concatenate([frames[:1].repeat(10, axis=0), frames[:-10]])


def _blurred(frames: NDArray[np.uint8]) -> NDArray[np.uint8]:
    mean = frames.astype(np.float32)
    for axis in (1, 2):
        mean = sum(np.roll(mean, by, axis) for by in range(-8, 9)) / 17
    return np.asarray(mean).astype(np.uint8)


def _of_another(copy: DatasetCopy) -> None:
    frames, span, other = copy.frames().copy(), copy.span(K), copy.span(K + 5)
    theirs = frames[other].copy()
    frames[span] = theirs[np.minimum(np.arange(span.stop - span.start), len(theirs) - 1)]
    copy.film(frames)


def _fewer(which: Callable[[DatasetCopy, int], slice]) -> Plant:
    def plant(copy: DatasetCopy) -> None:
        frames = copy.frames()
        copy.film(np.delete(frames, which(copy, len(frames)), axis=0))

    return plant


def _from_and_to(by: float) -> Plant:
    ends = [of_episode(f"VIDEO/{end}_timestamp", by) for end in ("from", "to")]
    return lambda copy: [plant(copy) for plant in ends]


def _header(name: str, value: Any) -> Plant:
    """Something else said of the video's encoding in info.json."""
    return lambda copy: copy.info["features"][copy.camera]["info"].update({name: value})


FAULTS = {
    "video_from_timestamp_wrong": Fault("video", of_episode("VIDEO/from_timestamp", 0.5), SPAN),
    "video_to_timestamp_wrong": Fault("video", of_episode("VIDEO/to_timestamp", 0.5), SPAN),
    "video_from_to_both_shifted": Fault("video", _from_and_to(0.5), SPAN),
    "video_file_index_wrong": Fault("video", of_episode("VIDEO/file_index", 1), FILE),
    "video_shape_wrong": Fault("video", feature("VIDEO", shape=[64, 64, 3]), SIZE),
    "video_codec_wrong_in_info": Fault("video", _header("video.codec", "h264"), "codec|h264|av1"),
    "video_fps_wrong_in_info": Fault("video", _header("video.fps", 30), "fps|rate"),
    "video_fewer_frames_inside": Fault(
        "video", _fewer(lambda copy, n: slice(copy.span(K).start + ROW, copy.span(K).start + 40)),
        FRAMES,
    ),
    "video_fewer_frames_at_end": Fault("video", _fewer(lambda copy, n: slice(n - 10, n)), FRAMES),
    "video_other_resolution": Fault(
        "video", lambda copy: copy.film(copy.frames()[:, ::2, ::2]), SIZE
    ),
    "video_30_fps": Fault(
        "video", lambda copy: copy.film(copy.frames(), fps=30),
        "fps|rate|time|video|span|end|frames",
    ),
    "video_h264_as_av1": Fault(
        "video", lambda copy: copy.film(copy.frames(), codec="libx264"), "codec|h264|av1|avc"
    ),
    "pictures_frozen_episode": Fault("pictures", _shown(_still(10)), STILL),
    "pictures_frozen_2s": Fault("pictures", _shown(_still(40, 80)), STILL),
    "pictures_black_episode": Fault("pictures", _shown(np.zeros_like), NOTHING),
    "pictures_of_another_episode": Fault(
        "pictures", _of_another, "sync|swap|duplicate|repeat|video|footage|another"
    ),
    "pictures_late_half_second": Fault("pictures", _shown(_late), "shift|sync|step|late|lag"),
    "pictures_blurred_episode": Fault("pictures", _shown(_blurred), "blur|sharp|detail"),
    "pictures_noise_episode": Fault(
        "pictures",
        _shown(lambda f: np.random.default_rng(0).integers(0, 255, f.shape, dtype=np.uint8)),
        "noise|corrupt|degenerate|blur|sharp|snow",
    ),
    "pictures_upside_down_episode": Fault(
        "pictures", _shown(lambda f: f[:, ::-1, ::-1]), "flip|rotat|camera|moved|view|upside"
    ),
    "pictures_bgr_episode": Fault(
        "pictures", _shown(lambda f: f[..., ::-1]), "channel|color|colour|bgr|rgb|red"
    ),
}  # fmt: skip
