"""Frames at a fixed rate from messages that come when they come. Times are int64, ns."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lfr.importing.bag.mapping import Method

SECOND = 10**9
Times = NDArray[np.int64]


def frame_times(start: int, fps: int, frames: int) -> Times:
    """When each frame is: frame k at start + k / fps, rounded down."""
    return start + np.arange(frames, dtype=np.int64) * SECOND // fps


def frames_between(start: int, end: int, fps: int) -> int:
    """How many frames there are from start to end, both included."""
    return -(-(end - start + 1) * fps // SECOND)


def pick(stamps: Times, times: Times, method: Method) -> NDArray[np.int64]:
    """The message of each frame: its place in `stamps`, which rise.

    Of two that are as near the earlier one is taken. A frame before the first message gets the
    first, which `missing` tells.
    """
    after = np.searchsorted(stamps, times, side="right")
    before = np.maximum(after - 1, 0)
    if method != "nearest":
        return before
    after = np.minimum(after, len(stamps) - 1)
    nearer = np.abs(stamps[after] - times) < np.abs(times - stamps[before])
    return np.where(nearer, after, before)


def missing(
    stamps: Times, start: int, fps: int, frames: int, method: Method, tolerance: float
) -> NDArray[np.int64]:
    """The frames for which there is no message: runs (R, 2) of the first and the last of each.

    They are found from the longer times between messages, of which there are few, without a list
    of all frames, which a clock that has jumped would make endless.
    """
    length = (frames - 1) * SECOND // fps + 1
    first = max(int(np.searchsorted(stamps, start, side="right")) - 1, 0)
    stamps = stamps[first : int(np.searchsorted(stamps, start + length)) + 1]
    reach = int(min(tolerance, 4 * 10**18))
    gaps = np.flatnonzero(np.diff(stamps) > reach)  # no frame is missing within the others
    ahead = reach if method == "nearest" else 0
    before = np.clip(stamps[np.append(gaps, -1)] - start, -(2**61), 2**61)
    after = np.clip(stamps[np.append(0, gaps + 1)] - start, -(2**61), 2**61)
    low = np.concatenate([[-1], np.minimum(before, length) + min(reach, 2**61)])
    high = np.concatenate([after - min(ahead, 2**61), [length]])
    low, high = np.clip(low, -1, length), np.clip(high, -1, length)
    later = -(-(low + 1) * fps // SECOND)  # the first frame after `low`
    earlier = -(-high * fps // SECOND) - 1  # the last one before `high`
    runs = np.stack([np.maximum(later, 0), np.minimum(earlier, frames - 1)], axis=1)
    return runs[runs[:, 0] <= runs[:, 1]]
