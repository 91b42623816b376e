"""Pictures of episodes that have been found again: the same packets, or decoded and compared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.curation.checks.decoded import COARSE, SIZE
from lfr.curation.diff.difference import Difference
from lfr.curation.diff.episodes import named
from lfr.curation.diff.in_common import overlap
from lfr.curation.diff.matching import Matching
from lfr.curation.diff.packets import Camera, Stretch
from lfr.curation.diff.side import Side
from lfr.curation.finding import Finding, Unreadable, unreadable
from lfr.progress import progress

OTHER, LASTING = 0.2, 0.08
"""Of white: how far a part of a picture, one of 12 x 12, is apart in another one; and how far on
the mean of an episode, where what encoding does to single pictures goes away.

Measured on the pictures of a simulator, 128 x 128: encoded again (AV1 of crf 30 and 45, H.264 of
crf 28 to 40, VP9, HEVC) parts are apart by 0.10 and 0.05 at most; of another episode by 0.73 and
0.23 at least, with a patch a sixteenth wide by 0.43 and 0.34, a tenth darker by 0.10 and 0.10.
"""


def compare_pictures(a: Side, b: Side, found: Matching, stride: int) -> Iterator[Difference]:
    """Of every camera that both have.

    Args:
        stride: every how many frames one is decoded, of episodes whose packets differ.
    """
    unread: set[tuple[str, str]] = set()
    for key in a.contents.pictures():
        if key not in b.contents.pictures():
            continue
        cameras = Camera(a, key), Camera(b, key)
        if found.pairs:
            for side in (a, b):
                side.contents.source.fetch("videos")
        for pair in progress(found.pairs, f"pictures of {key}", "episode"):
            name = "A"
            try:
                one = cameras[0].stretch(pair[0])
                name = "B"
                other = cameras[1].stretch(pair[1])
                name = "A or B"
                how = _compared(one, other, found.offsets.get(pair, 0), stride)
            except Unreadable as error:
                line = (name, str(error.finding))
                if line not in unread:
                    yield unread_pictures(name, key, error.finding)
                unread.add(line)
                continue
            if how is not None:
                kind, message, more = how
                yield Difference(kind, message, named(a, b, pair), column=key, **more)


def unread_pictures(name: str, key: str, finding: Finding) -> Difference:
    """Pictures of a camera that cannot be compared, in A or in B."""
    message = f"{finding.message}, in {name}: {finding.file or finding.column}"
    return Difference("unreadable", message, column=key)


How = tuple[str, str, dict[str, Any]]


def _compared(one: Stretch, other: Stretch, offset: int, stride: int) -> How | None:
    if one.frames == other.frames and one.fingerprint == other.fingerprint:
        return None
    x, y = overlap(offset, one.frames, other.frames)
    places = range(0, x.stop - x.start, stride)
    differences = [
        _parts(before - after)
        for before, after in zip(
            small_pictures(one, [x.start + i for i in places]),
            small_pictures(other, [y.start + i for i in places]), strict=True,
        )
    ]  # fmt: skip
    if not differences:
        return None
    single = np.abs(differences).max(axis=(1, 2, 3))
    largest = float(single.max())
    lasting = float(np.abs(np.mean(differences, axis=0)).max())
    if largest > OTHER or lasting > LASTING:
        rows = int((single > OTHER).sum()) if largest > OTHER else len(single)
        message = "other pictures" + (f", of one in {stride} looked at" if stride > 1 else "")
        return "pictures", message, {"rows": rows, "largest": largest}
    if one.frames != other.frames:
        return None  # what was cut is said where rows are compared
    formats = one.packets.format, other.packets.format
    more = dict(zip("ab", formats, strict=True)) if formats[0] != formats[1] else {}
    return "encoded-anew", "the same pictures, encoded anew", {**more, "largest": largest}


def small_pictures(stretch: Stretch, frames: Sequence[int]) -> Iterator[NDArray[np.float32]]:
    """(SIZE, SIZE, 3) of these frames of an episode, in their order, white is 1.

    Raises:
        Unreadable: one cannot be decoded.
    """
    import av
    from av.error import FFmpegError

    packets, at = stretch.packets, -1
    with unreadable("damaged-picture", "a frame that cannot be decoded", FFmpegError, OSError,
                    StopIteration, file=packets.path.name), \
            av.open(str(packets.path)) as container:  # fmt: skip
        stream = container.streams.video[0]
        stream.thread_type = "AUTO"
        decoded = container.decode(stream)
        for number in frames:
            wanted = stretch.first + number
            key = packets.key_before(wanted)
            if at < 0 or key > at + 1:
                container.seek(int(packets.times[key]), stream=stream)
                decoded = container.decode(stream)
            frame: Any = None
            while frame is None or at < wanted:
                frame = next(decoded)
                at = int(np.searchsorted(packets.times, frame.pts))
            small = frame.reformat(SIZE, SIZE, "rgb24", interpolation="AREA").to_ndarray()
            yield small.astype(np.float32) / 255


def _parts(difference: NDArray[np.float32]) -> NDArray[np.float32]:
    """(COARSE, COARSE, 3) means of a picture's parts."""
    part = SIZE // COARSE
    return difference.reshape(COARSE, part, COARSE, part, 3).mean(axis=(1, 3))
