"""Which message a frame takes, and which frames have none, against a look at every pair."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lfr.importing.bag.resample import SECOND, frame_times, frames_between, missing, pick

stamps = st.lists(st.integers(0, 3 * SECOND), min_size=1, max_size=30).map(sorted)
rates = st.sampled_from([1, 7, 10, 30, 60, 1000])
methods = st.sampled_from(["nearest", "previous", "hold"])


@given(stamps, st.integers(0, 3 * SECOND), rates, st.integers(2, 80), methods)
def test_a_frame_takes_the_message_that_is_nearest_or_the_last(
    stamps: list[int], start: int, fps: int, frames: int, method: str
) -> None:
    times = frame_times(start, fps, frames)
    found = pick(np.array(stamps), times, method)  # pyright: ignore[reportArgumentType]
    for time, place in zip(times.tolist(), found.tolist(), strict=True):
        if method == "nearest":
            assert abs(stamps[place] - time) == min(abs(s - time) for s in stamps)
        elif stamps[0] <= time:
            assert stamps[place] == max(s for s in stamps if s <= time)


@given(
    stamps, st.integers(0, 3 * SECOND), rates, st.integers(2, 80), methods,
    st.integers(1, SECOND),
)  # fmt: skip
def test_frames_without_a_message_within_tolerance(
    stamps: list[int], start: int, fps: int, frames: int, method: str, tolerance: int
) -> None:
    limit = float("inf") if method == "hold" else tolerance
    runs = missing(np.array(stamps), start, fps, frames, method, limit)  # pyright: ignore[reportArgumentType]
    found = {frame for first, last in runs.tolist() for frame in range(first, last + 1)}
    expected = set()
    for frame, time in enumerate(frame_times(start, fps, frames).tolist()):
        usable = stamps if method == "nearest" else [s for s in stamps if s <= time]
        if not any(abs(s - time) <= limit for s in usable):
            expected.add(frame)
    assert found == expected


@given(st.integers(0, 10**18), st.integers(0, 10 * SECOND), rates)
def test_as_many_frames_as_fit(start: int, length: int, fps: int) -> None:
    frames = frames_between(start, start + length, fps)
    times = frame_times(start, fps, frames + 1)
    assert times[frames - 1] <= start + length < times[frames]


def test_a_pause_of_days_is_one_run() -> None:
    pause = 10 * 86_400 * SECOND
    times = np.array([0, SECOND // 10, pause + SECOND // 5])
    frames = frames_between(0, int(times[-1]), 10)
    assert missing(times, 0, 10, frames, "nearest", SECOND / 10).tolist() == [[3, 8_640_000]]
