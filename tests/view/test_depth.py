"""Depth is seen, whether it is kept as pictures of 16 bits, in a video, or as tables of numbers."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lfr.data.episode import ACTION, STATE
from lfr.view.dataset import read_episode
from lfr.view.depth import is_picture, scaled

from .test_anybodys_dataset import Written, opened, vector, write

HEIGHT, WIDTH = 64, 96


def depth(t: int) -> np.ndarray:
    """A slope in millimetres that a block approaches; nothing is measured at its left."""
    slope = np.tile(np.linspace(600, 3000, WIDTH), (HEIGHT, 1))
    slope[20:40, 30 + 4 * t : 50 + 4 * t] = 500 + 10 * t
    slope[:, :5] = 0
    return slope.astype(np.uint16)


def recorded(root: Path, feature: dict, frame: object) -> Written:
    features = {STATE: vector(3), ACTION: vector(2), "observation.depth.front": feature}
    episodes = [
        [
            {STATE: np.zeros(3, np.float32), ACTION: np.zeros(2, np.float32),
             "observation.depth.front": frame(depth(t))}  # pyright: ignore[reportCallIssue]
            for t in range(6)
        ]
    ]  # fmt: skip
    return write(root, "arm", 10, features, episodes)


AS_PICTURE = {"shape": (HEIGHT, WIDTH, 1), "names": ["height", "width", "channels"],
              "info": {"is_depth_map": True}}  # fmt: skip
KINDS = {
    "pictures": ({"dtype": "image", **AS_PICTURE}, lambda d: d[..., None]),
    "table": ({"dtype": "float32", "shape": (HEIGHT, WIDTH), "names": ["height", "width"]},
              lambda d: d.astype(np.float32)),
    "table of one channel": ({"dtype": "uint16", "shape": (1, HEIGHT, WIDTH), "names": None},
                             lambda d: d[None]),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_it_spans_black_to_white(kind: str, tmp_path: Path) -> None:
    feature, frame = KINDS[kind]
    episode = read_episode(recorded(tmp_path / "arm", feature, frame).path, 0)
    assert "observation.depth.front" not in episode.features  # no curve for each pixel
    shown = [
        np.asarray(Image.open(io.BytesIO(f)).convert("L")) for f in episode.images["depth.front"]
    ]
    for t, picture in enumerate(shown):
        millimetres = depth(t).astype(float)
        expected = np.where(millimetres > 0, 255 * (millimetres - 500) / (3000 - 500), 0)
        assert np.abs(picture - expected).mean() < 3  # JPEG


def test_a_video_of_it_too(tmp_path: Path) -> None:
    """LeRobot keeps it in 12 bits, near and far unequally: order and span are told."""
    kind = {"dtype": "video", **AS_PICTURE}
    path = recorded(tmp_path / "arm", kind, lambda d: d[..., None]).path
    episode = read_episode(path, 0)
    picture = np.asarray(Image.open(io.BytesIO(episode.images["depth.front"][0])).convert("L"))
    far = picture[50, 10:90].astype(int)
    assert far[0] < far[40] < far[-1]
    assert far[-1] > 240
    assert picture[30, 35] < 15


def test_it_is_a_camera_in_the_recording(tmp_path: Path) -> None:
    feature, frame = KINDS["table"]
    entities = opened(recorded(tmp_path / "arm", feature, frame).path, tmp_path / "out.rrd")
    assert "EncodedImage:blob" in entities["/camera/depth.front"]
    assert "/observation/front" not in entities


@pytest.mark.parametrize(
    ("shape", "expected"),
    [((48, 64), True), ((48, 64, 1), True), ((1, 48, 64), True), ((48, 64, 3), True),
     ((14,), False), ((4, 4), False), ((2, 3), False), ((20, 7), False), ((3, 48, 64, 9), False),
     ((1,), False), ((), False)],
)  # fmt: skip
def test_what_is_a_picture(shape: tuple[int, ...], expected: bool) -> None:
    assert is_picture(shape) is expected


def test_what_has_no_range() -> None:
    (flat,) = scaled([np.full((8, 8), 3.0)])
    (nothing,) = scaled([np.full((8, 8), np.nan)])
    assert np.asarray(flat).max() == np.asarray(nothing).max() == 0
    (some,) = scaled([np.array([[1.0, np.inf], [np.nan, 2.0]])])
    assert np.asarray(some).tolist() == [[0, 0], [0, 255]]
    assert scaled([]) == []
