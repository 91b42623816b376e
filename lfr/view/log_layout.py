"""The layout of a raw MCAP log in plain `rerun`, as the committed file `log.rbl` holds it.

rerun reads a log's poses and pictures by itself; our own messages and the joints arrive as
structures, of which a view plots a field where its layout names it. The fields of an action are its
controller's: the committed file is for any arm under OSC_POSE, and
`python -m lfr.view.log_layout ur5e-joint_position ur5e.rbl` writes that of another embodiment, with
`agentview wrist` after it that of logs with these cameras. Without arguments it writes the
committed file anew; `rerun episode-000000.mcap log.rbl` opens a log
with it.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lfr.data import messages
from lfr.embodiments import Embodiment, embodiment
from lfr.view import series
from lfr.view.action import GRIPPER, motion_title
from lfr.view.blueprint import BACKGROUND, UNIT, pictures_view
from lfr.view.eye import Eye
from lfr.view.series import Color

if TYPE_CHECKING:
    import rerun.blueprint as rrb

FILE = Path(__file__).with_name("log.rbl")
APPLICATION = "lfr-log"
WORLD = "world"
"""The frame of a log's poses that all others are placed in."""
CAMERAS = ("agentview",)
"""Whose pictures the committed layouts show."""
FRAMES = "Bodies and camera"
AXES = 0.08
"""m, length of a frame's axes."""
EYE = Eye(position=np.array([1.6, -1.2, 1.7]), target=np.array([-0.1, 0.0, 0.95]))
"""Before the table, a little to its side and above, wherever the task has its objects."""

MESSAGE, TIMELINE = "message", "message_log_time"


@dataclass(frozen=True)
class Plot:
    """Curves of one view, from the fields of one topic.

    Attributes:
        name: of the view.
        topic: that the messages are on.
        schema: of the messages.
        fields: selector -> name in the legend, or names where it selects several numbers.
        span: of the vertical axis, where it is known.
        colors: of the curves.
    """

    name: str
    topic: str
    schema: str
    fields: Mapping[str, str | tuple[str, ...]]
    span: tuple[float, float] | None = None
    colors: Sequence[Color] = series.PALETTE


DEFAULT = "panda"
"""Whose logs the committed layouts are for: those of any arm of seven joints under OSC_POSE."""


def plots(body: Embodiment) -> tuple[Plot, ...]:
    """What every log of an embodiment has; the objects' names differ from task to task."""
    joints = tuple(f"joint {number}" for number in range(len(body.robot.joints)))
    return (
        *_motions(body),
        Plot("Action: gripper (-1 open, +1 closed)", messages.ACTION, "lfr.Action",
             {f".{GRIPPER}": GRIPPER}, UNIT, (series.AMBER,)),
        Plot("End effector (m)", messages.OBSERVATION, "lfr.Observation",
             {".eef_pos_x": "x", ".eef_pos_y": "y", ".eef_pos_z": "z"}),
        Plot("Gripper aperture (m)", messages.OBSERVATION, "lfr.Observation",
             {".gripper_aperture": "aperture"}, None, (series.TEAL,)),
        Plot("Reward", messages.REWARD, "lfr.Reward", {".reward": "reward"}, None,
             (series.VIOLET,)),
        Plot("Success", messages.SUCCESS, "lfr.Success", {".success": "success"}, (-0.05, 1.05),
             (series.GREEN,)),
        Plot("Joints (rad)", messages.JOINT_STATES, "foxglove.JointStates",
             {".joints[].position": joints}),
    )  # fmt: skip


def _motions(body: Embodiment) -> list[Plot]:
    """The quantities of the action, but for the gripper."""
    found = []
    for each in body.action.quantities:
        if each.name != GRIPPER:
            names = zip(each.names, each.parts, strict=True)
            fields = {f".{messages.identifier(name)}": part for name, part in names}
            found.append(Plot(motion_title(each), messages.ACTION, "lfr.Action", fields, UNIT))
    return found


def log_blueprint(body: Embodiment, cameras: Sequence[str] = CAMERAS) -> rrb.Blueprint:
    """Frames and cameras at the left, the series at the right."""
    import rerun.blueprint as rrb

    frames = rrb.Spatial3DView(
        origin="/",
        contents=["/tf/**", "/camera/**"],
        name=FRAMES,
        background=rrb.archetypes.Background(kind="SolidColor", color=BACKGROUND),
        spatial_information=rrb.SpatialInformation(target_frame=WORLD, show_axes=True),
        eye_controls=rrb.EyeControls3D(position=EYE.position, look_target=EYE.target),
        overrides={"/tf": _axes()},
    )
    pictures = [
        rrb.Spatial2DView(origin=messages.CAMERA + camera, name=camera) for camera in cameras
    ]
    left = rrb.Vertical(frames, pictures_view(pictures), row_shares=[2, 1]) if cameras else frames
    right = rrb.Grid(*map(_view, plots(body)), grid_columns=2)
    return rrb.Blueprint(
        rrb.Horizontal(left, right, column_shares=[1, 1.4]),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, loop_mode="All", play_state="Playing"),
    )


def _view(plot: Plot) -> rrb.View:
    import rerun as rr
    import rerun.blueprint as rrb
    from rerun.blueprint.datatypes import ComponentSourceKind, VisualizerComponentMapping

    def style(place: int, names: str | tuple[str, ...]) -> rr.SeriesLines:
        """Colours in their order, over the fields or over the numbers that one field selects."""
        every = (names,) if isinstance(names, str) else names
        colors = [plot.colors[(place + k) % len(plot.colors)] for k in range(len(every))]
        return rr.SeriesLines(names=list(every), colors=colors)

    curves = [
        style(k, name).visualizer(
            mappings=[
                VisualizerComponentMapping(
                    "Scalars:scalars",
                    ComponentSourceKind.SourceComponent,
                    source_component=f"{plot.schema}:{MESSAGE}",
                    selector=selector,
                )
            ]
        )
        for k, (selector, name) in enumerate(plot.fields.items())
    ]
    whole = rr.TimeRange(rr.TimeRangeBoundary.infinite(), rr.TimeRangeBoundary.infinite())
    overrides: dict[Any, Any] = {plot.topic: curves}
    return rrb.TimeSeriesView(
        origin="/",
        contents=[plot.topic],
        name=plot.name,
        axis_x=rrb.archetypes.TimeAxis(view_range=whole),
        axis_y=rrb.ScalarAxis(range=plot.span) if plot.span else None,
        overrides=overrides,
    )


def _axes() -> Any:
    import rerun as rr

    return rr.TransformAxes3D(axis_length=AXES).visualizer()


def wanted(file: Path) -> tuple[Embodiment, Path, tuple[str, ...]]:
    """Whose layout the command line asks for, where to, and with which cameras.

    By default it is the committed ``file``.
    """
    parser = argparse.ArgumentParser()
    parser.add_argument("embodiment", nargs="?", default=DEFAULT)
    parser.add_argument("out", nargs="?", type=Path, default=file)
    parser.add_argument("cameras", nargs="*", default=CAMERAS, help="as record.cameras names them")
    options = parser.parse_args()
    return embodiment(options.embodiment), options.out, tuple(options.cameras)


if __name__ == "__main__":
    body, out, cameras = wanted(FILE)
    log_blueprint(body, cameras).save(APPLICATION, str(out))
