"""Faults of episodes as recordings: too short or long, idle, there twice, two in one; on `arm`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.checkers.bases import SENSOR
from benchmarks.checkers.dataset_copy import DatasetCopy
from benchmarks.checkers.faults.behaviour import SPIKE, STUCK, edit, on_arm
from benchmarks.checkers.faults.fault import K, Plant

LENGTH = "length|duration|short|long|outlier|frame"
TWICE = "dup|identical|same|repeat|copy"


def _parts(change: Callable[[list[NDArray]], tuple[list[NDArray], list[int]]]) -> Plant:
    """Episodes made of other rows, of which all is counted anew."""

    def plant(copy: DatasetCopy) -> None:
        copy.rebuild(*change([np.r_[copy.span(e)] for e in range(copy.episodes.num_rows)]))

    return plant


def _with(rows: Callable[[NDArray], NDArray]) -> Plant:
    """One episode of other rows."""
    return _parts(lambda parts: ([*parts[:K], rows(parts[K]), *parts[K + 1 :]],
                                 [*range(len(parts))]))  # fmt: skip


def _idle(seconds: int, *, first: bool) -> Plant:
    """The recording begins before the task, or goes on after it."""
    frames = 20 * seconds
    longer = _with(lambda part: np.r_[part[:1].repeat(frames * first), part,
                                      part[-1:].repeat(frames * (not first))])  # fmt: skip

    def plant(copy: DatasetCopy) -> None:
        longer(copy)
        span = copy.span(K)
        start = span.start if first else span.stop - frames
        noise = np.random.default_rng(3).normal(0, SENSOR, (frames, 8)).astype(np.float32)

        def change(states: NDArray, actions: NDArray) -> None:
            states[start : start + frames] += noise

        edit(copy, change)

    return plant


def _nearly_twice(copy: DatasetCopy) -> None:
    """The same motion measured again."""
    _twice(copy)
    last = copy.span(copy.episodes.num_rows - 1)
    noise = np.random.default_rng(4).normal(0, SENSOR, (last.stop - last.start, 8))

    def change(*arrays: NDArray) -> None:
        for array in arrays:
            array[last] += noise.astype(np.float32)

    edit(copy, change)


def _joined(parts: list[NDArray]) -> tuple[list[NDArray], list[int]]:
    origins = [e for e in range(len(parts)) if e != K + 1]
    return [np.r_[parts[e], parts[e + 1]] if e == K else parts[e] for e in origins], origins


_twice = _parts(lambda parts: ([*parts, parts[K]], [*range(len(parts)), K]))


FAULTS = {
    "episode_of_one_frame": on_arm(_with(lambda part: part[:1]), LENGTH),
    "idle_begin_10s": on_arm(_idle(10, first=True), f"{STUCK}|{LENGTH}|pad|stall|motion"),
    "idle_end_10s": on_arm(_idle(10, first=False), f"{STUCK}|{LENGTH}|pad|stall|motion"),
    "episode_slow_5x": on_arm(_with(lambda part: part.repeat(5)), LENGTH),
    "episode_twice": on_arm(_twice, TWICE),
    "episode_nearly_twice": on_arm(_nearly_twice, TWICE),
    "two_episodes_in_one": on_arm(_parts(_joined), f"{SPIKE}|reset|{LENGTH}"),
}
