"""A card's picture: an episode's course in a few of its frames, side by side."""

from __future__ import annotations

import io
from pathlib import Path

from lfr.data.tables import DatasetFiles
from lfr.errors import DataError

FRAMES = 4
QUALITY = 80  # of the JPEG; 4 frames of 128 x 128 pixels take about 12 kB


def picture(dataset: Path, camera: str) -> bytes:
    """Frames of episode 0, first to last, evenly spaced: one JPEG.

    Args:
        dataset: its folder.
        camera: key of the video feature.

    Raises:
        DataError: the video has fewer frames than the episode.
    """
    from PIL import Image

    files = DatasetFiles.open(dataset)
    row = files.episodes.slice(0, 1).to_pylist()[0]
    chunk, file = (row[f"videos/{camera}/{index}_index"] for index in ("chunk", "file"))
    path = dataset / files.info["video_path"].format(
        video_key=camera, chunk_index=chunk, file_index=file
    )
    first = round(row[f"videos/{camera}/from_timestamp"] * files.info["fps"])
    shown = _frames(path, [first + k * (row["length"] - 1) // (FRAMES - 1) for k in range(FRAMES)])
    width, height = shown[0].size
    strip = Image.new("RGB", (len(shown) * width, height))
    for place, image in enumerate(shown):
        strip.paste(image, (place * width, 0))
    out = io.BytesIO()
    strip.save(out, "JPEG", quality=QUALITY, optimize=True)
    return out.getvalue()


def _frames(path: Path, wanted: list[int]) -> list:
    """The frames of these numbers, in order, as PIL images."""
    import av

    found = {}
    with av.open(str(path)) as container:
        for number, frame in enumerate(container.decode(video=0)):
            if number in wanted:
                found[number] = frame.to_image()
            if number >= max(wanted):
                break
    if set(wanted) - set(found):
        raise DataError(
            "the video ends before its first episode",
            file=path,
            found=f"{len(found)} of the frames {wanted}",
        )
    return [found[number] for number in wanted]
