"""A card's picture: an episode's course in a few of its frames, side by side."""

from __future__ import annotations

import io
from pathlib import Path

from lfr.data.pictures import frames
from lfr.data.tables import DatasetFiles

FRAMES = 4
QUALITY = 80  # of the JPEG; 4 frames of 128 x 128 pixels take about 12 kB


def picture(dataset: Path, camera: str) -> bytes:
    """Frames of the first episode, first to last, evenly spaced: one JPEG.

    Args:
        dataset: its folder.
        camera: key of the video feature.

    Raises:
        DataError: there is no episode, its video is missing or does not play, or has fewer frames.
    """
    from PIL import Image

    files = DatasetFiles.open(dataset)
    row = files.episode(min(files.episodes["episode_index"].to_pylist()))
    file = files.file_of(row, f"videos/{camera}")
    first = round(files.number(row, f"videos/{camera}/from_timestamp") * files.fps)
    numbers = [first + k * (row["length"] - 1) // (FRAMES - 1) for k in range(FRAMES)]
    wanted = sorted(set(numbers))
    images = (frame.to_image() for frame in frames(file, wanted, camera))
    found = dict(zip(wanted, images, strict=True))
    shown = [found[number] for number in numbers]
    width, height = shown[0].size
    strip = Image.new("RGB", (len(shown) * width, height))
    for place, image in enumerate(shown):
        strip.paste(image, (place * width, 0))
    out = io.BytesIO()
    strip.save(out, "JPEG", quality=QUALITY, optimize=True)
    return out.getvalue()
