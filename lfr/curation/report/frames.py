"""Frames of an episode's videos beside the same frames of another, as small JPEG files in words."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from lfr.curation.contents import Contents
from lfr.curation.finding import Finding
from lfr.data.pictures import frames

PICTURED = (
    "damaged-picture",
    "blank-picture",
    "noisy-picture",
    "blurred-picture",
    "view",
    "frozen-picture",
    "other-pictures",
    "shifted-pictures",
)
"""Kinds that are about what a video shows."""
WIDTH = 240  # pixels
SHARES = (0.1, 0.5, 0.9)  # of what a finding is about, where its frames are


@dataclass(frozen=True)
class Shot:
    """A frame of an episode.

    Attributes:
        episode, frame: which.
        picture: `data:image/jpeg;base64,...`.
    """

    episode: int
    frame: int
    picture: str


def chosen_frames(finding: Finding, length: int) -> list[int]:
    """Three frames out of those that a finding is about, or fewer where these are fewer."""
    first, last = finding.frames or (0, length - 1)
    last = min(last, length - 1)
    return sorted({round(first + share * (last - first)) for share in SHARES})


def shots(contents: Contents, key: str, episode: int, wanted: Sequence[int]) -> Iterator[Shot]:
    """Frames of an episode, which rise, as one camera shows them.

    Args:
        key: the camera's feature.

    Raises:
        DataError: they cannot be decoded.
        Unreadable: the dataset does not say where they are.
    """
    placed = contents.placed_in(f"videos/{key}")
    name = next((name for name, episodes in placed.items() if episode in episodes), None)
    if name is None or not wanted:
        return
    start = contents.episode_column(f"videos/{key}/from_timestamp")[episode]
    first = int(np.rint(start * contents.fps))
    numbers = [first + frame for frame in wanted]
    found = frames(contents.path / name, numbers, key)
    for frame, picture in zip(wanted, found, strict=False):
        image = picture.to_image()
        image.thumbnail((WIDTH, WIDTH))
        buffer = io.BytesIO()
        image.save(buffer, "JPEG", quality=72)
        text = base64.b64encode(buffer.getvalue()).decode("ascii")
        yield Shot(episode, frame, f"data:image/jpeg;base64,{text}")
