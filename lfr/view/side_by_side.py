"""Two recordings as one: two episodes, or two arms, side by side on one timeline.

Every entity of the one stands below `/left`, of the other below `/right`; both begin at time 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfr.errors import DataError
from lfr.view import series
from lfr.view.action import GRIPPER
from lfr.view.collection import arrange
from lfr.view.eye import eye_on
from lfr.view.side_by_side_layout import Side, beside_blueprint

if TYPE_CHECKING:
    from rerun.experimental import Chunk

LEFT, RIGHT = "/left", "/right"
COLORS = {LEFT: series.VIOLET, RIGHT: series.AMBER}
PATH = "/path/end_effector"  # of an arm without geometry (lfr.view.path)
GRIPPER_STATE = "/state/gripper"  # of a known embodiment's action (lfr.view.features)
PROPERTIES, NAME = "/__properties", "RecordingInfo:name"
RENAMED = {"/reward": "reward"}
"""Entities whose curves of both sides share a view, and what each curve is called there."""


@dataclass(frozen=True)
class _Recording:
    """What one `.rrd` file holds."""

    name: str
    chunks: list[Chunk]


def save_side_by_side(out: Path, left: Path, right: Path, *, at: float | None = None) -> None:
    """Write the recordings of two `.rrd` files as one, with a layout of two halves.

    Args:
        out: the file.
        left, right: files of one recording each, on the timelines `time` and `frame`.
        at: s; the viewer stands there instead of playing.

    Raises:
        DataError: a file that holds no episode.
    """
    import rerun as rr

    both = {LEFT: _read(left), RIGHT: _read(right)}
    sides = [_side(root, recording) for root, recording in both.items()]
    blueprint = beside_blueprint(*sides)
    arrange(blueprint, choice=False, at=at)
    title = " | ".join(side.title for side in sides)
    with rr.RecordingStream(title) as stream:
        stream.save(out, default_blueprint=blueprint)
        stream.send_recording_name(title)
        for root, recording in both.items():
            stream.send_chunks(
                chunk.with_entity_path(root + chunk.entity_path) for chunk in recording.chunks
            )
            for entity, name in RENAMED.items():
                style = rr.SeriesLines(
                    names=[f"{name}, {root.strip('/')}"], colors=[COLORS[root]], widths=[2.0]
                )
                stream.log(root + entity, style, static=True)
        stream.flush()
        stream.disconnect()


def _read(file: Path) -> _Recording:
    from rerun.experimental import RrdReader

    reader = RrdReader(file)
    if (count := len(reader.recordings())) != 1:
        raise DataError("cannot stand beside another", file=file, found=f"{count} recordings",
                        expected="one episode")  # fmt: skip
    name, chunks = file.stem, []
    for chunk in reader.stream().to_chunks():
        if not chunk.entity_path.startswith(PROPERTIES):
            chunks.append(chunk)
        elif NAME in (batch := chunk.to_record_batch()).schema.names:
            name = batch.column(NAME).to_pylist()[0][0]
    if not any("time" in chunk.timeline_names for chunk in chunks):
        raise DataError("cannot stand beside another", file=file, found="no timeline 'time'",
                        expected="an episode")  # fmt: skip
    return _Recording(name, chunks)


def _side(root: str, recording: _Recording) -> Side:
    entities = {chunk.entity_path for chunk in recording.chunks}
    cameras = sorted(e.removeprefix("/camera/") for e in entities if e.startswith("/camera/"))
    own = GRIPPER_STATE in entities
    shown = ("/action/",) if own else ("/action/", "/observation/")
    plots = sorted(e.removeprefix("/") for e in entities if e.startswith(shown))
    eye = eye_on(_moving(recording.chunks))
    if not own:
        return Side(root, recording.name, tuple(cameras), eye, series=tuple(plots))
    actions = tuple(name for e in plots if (name := e.removeprefix("action/")) != GRIPPER)
    return Side(root, recording.name, tuple(cameras), eye, actions=actions)


def _moving(chunks: list[Chunk]) -> NDArray[np.float64]:
    """Where the bodies that move are at any time, (N, 3) in the world (m); else the path."""
    bodies = [
        _points(chunk, "Transform3D:translation")
        for chunk in chunks
        if not chunk.is_static and chunk.entity_path.startswith("/world/")
    ]
    path = [_points(c, "LineStrips3D:strips") for c in chunks if c.entity_path == PATH]
    found = np.concatenate([np.zeros((0, 3)), *(bodies or path)])
    found = found[np.isfinite(found).all(axis=1)]
    return found if len(found) else np.zeros((1, 3))


def _points(chunk: Chunk, component: str) -> NDArray[np.float64]:
    """All points (N, 3) of a component, however its lists are nested."""
    batch = chunk.to_record_batch()
    if component not in batch.schema.names:
        return np.zeros((0, 3))
    column = batch.column(component)
    while hasattr(column.type, "value_type"):
        column = column.flatten()
    return column.to_numpy().reshape(-1, 3)
