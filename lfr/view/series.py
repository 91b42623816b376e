"""Named curves over an episode's frames, and the colours that all views share."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from lfr.data.episode import FPS, Episode

if TYPE_CHECKING:
    import rerun as rr

Color = tuple[int, int, int]

RED, GREEN, BLUE = (240, 86, 92), (76, 195, 112), (82, 150, 255)  # x, y, z
AMBER, TEAL, VIOLET = (255, 178, 56), (64, 200, 200), (176, 132, 255)
GREY, WHITE = (150, 155, 165), (236, 238, 242)
PALETTE: tuple[Color, ...] = (RED, GREEN, BLUE, AMBER, TEAL, VIOLET, GREY, WHITE)
OPEN_COLOR, CLOSING_COLOR = BLUE, AMBER  # what the gripper is told to do


def fps_of(episode: Episode) -> float:
    """Frames per second of an episode: what its log or dataset says, else this project's."""
    return float(episode.metadata.get("fps") or FPS)


def entity_part(name: str) -> str:
    """A name as a part of an entity's path; rerun would have anything else escaped."""
    return re.sub(r"[^A-Za-z0-9_.-]", "_", name)


def frame_times(frames: ArrayLike, fps: float = FPS) -> list[rr.TimeColumn]:
    """The two timelines of an episode: `time` (s from its start) and `frame`."""
    import rerun as rr

    numbers = np.asarray(frames, dtype=np.int64)
    return [rr.TimeColumn("time", duration=numbers / fps), rr.TimeColumn("frame", sequence=numbers)]


def log_series(
    recording: rr.RecordingStream,
    path: str,
    times: Sequence[rr.TimeColumn],
    values: ArrayLike,
    names: Sequence[str],
    colors: Sequence[Color] = PALETTE,
    *,
    width: float = 1.5,
    steps: bool = False,
) -> None:
    """Log curves that share one entity.

    Args:
        recording: where to log to.
        path: the entity.
        times: columns of N times.
        values: (N, K), or (N,) for one curve.
        names: K names, for the legend.
        colors: of the curves, used again from the first when there are more curves.
        width: of the lines, in points.
        steps: hold each value until the next one instead of joining them.
    """
    import rerun as rr

    table = np.asarray(values, dtype=np.float64)
    table = table.reshape(len(table), -1)  # (N, K)
    style = rr.SeriesLines(
        names=list(names),
        colors=[colors[k % len(colors)] for k in range(table.shape[1])],
        widths=[width] * table.shape[1],
        interpolation_mode="StepAfter" if steps else "Linear",
    )
    recording.log(path, style, static=True)
    recording.send_columns(path, indexes=times, columns=rr.Scalars.columns(scalars=table))


def log_states(
    recording: rr.RecordingStream,
    path: str,
    times: Sequence[rr.TimeColumn],
    states: Sequence[str],
    colors: dict[str, Color],
) -> None:
    """Log which of the named states of `colors` holds from each time on, as a coloured lane."""
    import rerun as rr

    style = rr.StateConfiguration(values=list(colors), colors=list(colors.values()))
    recording.log(path, style, static=True)
    recording.send_columns(path, indexes=times, columns=rr.StateChange.columns(state=list(states)))
