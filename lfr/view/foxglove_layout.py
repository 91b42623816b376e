"""The layout of a raw MCAP log in Foxglove, as the committed file `foxglove.json` holds it.

It shows what `log_layout` shows in rerun. The panels' options are foxglove-sdk's; around them is
the form in which Foxglove exports a layout and imports it from a file, which its open-source
relative Lichtblick shares. `python -m lfr.view.foxglove_layout` writes the file anew, with the
arguments of `log_layout` that of another embodiment.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from itertools import batched
from pathlib import Path
from typing import Any, Literal

import foxglove.layouts as fl
import numpy as np

from lfr.data import messages
from lfr.embodiments import Embodiment
from lfr.view.blueprint import BACKGROUND
from lfr.view.log_layout import AXES, CAMERAS, EYE, FRAMES, WORLD, Plot, plots, wanted
from lfr.view.series import GREY, VIOLET, Color

FILE = Path(__file__).with_name("foxglove.json")

TITLES = ("foxglovePanelTitle", "lichtblickPanelTitle")
AXIS = 0.2
"""m, length of a frame's axes at `axisScale` 1 (Foxglove Studio, `renderables/Axis.ts`)."""
TABLE = 0.8
"""m, height of the table, at which the grid lies (robosuite's `table_offset`)."""

Place = str | dict[str, Any]
"""A panel, by its name, or two places and how they share theirs."""


def foxglove_layout(body: Embodiment, cameras: Sequence[str] = CAMERAS) -> dict[str, Any]:
    """Frames, cameras and observation at the left, the series at the right.

    The name of a panel is its type, `!`, and what tells it from others of that type.
    """
    numbers = fl.RawMessagesConfig(topic_path=messages.OBSERVATION, expansion="all")
    curves = {
        f"Plot!{number}": _options(plot.name, _plot(plot))
        for number, plot in enumerate(plots(body), start=1)
    }
    configurations = {
        "3D!bodies": _bodies(cameras),
        **{f"Image!{camera}": _picture(camera) for camera in cameras},
        "RawMessages!observation": _options("Observation", numbers),
    }
    frames, *others = configurations
    left = _shared("column", [frames, _shared("row", others)], [2, 1])
    right = _shared("column", [_shared("row", pair) for pair in batched(curves, 2)])
    return {
        "configById": {**configurations, **curves},
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _shared("row", [left, right], [1, 1.4]),
    }


def _picture(camera: str) -> dict[str, Any]:
    mode = fl.ImageModeConfig(image_topic=messages.CAMERA + camera)
    return _options(camera, fl.ImageConfig(image_mode=mode))


def _bodies(cameras: Sequence[str]) -> dict[str, Any]:
    settings = fl.BaseRendererSceneSettings(
        background_color=_hex(BACKGROUND),
        # Preloaded, because a fixed camera's pose is logged once, at the start.
        transforms=fl.BaseRendererTransforms(
            show_label=True, label_size=0.03, enable_preloading=True
        ),
    )
    grid = fl.BaseRendererGridLayerSettings(
        visible=True, instance_id="table", label="Table", frame_id=WORLD, size=2, divisions=20,
        line_width=1, color=_hex(GREY), position=(0, 0, TABLE), rotation=(0, 0, 0),
    )  # fmt: skip
    frustum = fl.BaseRendererCameraTopicSettings(
        visible=True, distance=0.3, width=0.003, color=_hex(VIOLET)
    )
    config = fl.ThreeDeeConfig(
        camera_state=_camera_state(),
        follow_tf=WORLD,
        follow_mode="follow-pose",
        scene=settings,
        # Every pose is one in the world: shown, it would have a line to each of them.
        transforms={f"frame:{WORLD}": fl.BaseRendererLayerSettingsTransform(visible=False)},
        topics={messages.CAMERA + camera + messages.CALIBRATION: frustum for camera in cameras},
        layers={"table": grid},
    )
    options = _options(FRAMES, config)
    # Exported layouts call it so; foxglove-sdk knows `axisSize` alone.
    options["scene"]["transforms"]["axisScale"] = round(AXES / AXIS, 3)
    return options


def _camera_state() -> fl.ThreeDeeCameraState:
    """The eye, as Foxglove has it: from the target, `distance` times
    (-sin phi sin theta, -sin phi cos theta, cos phi), angles in degrees."""
    away = EYE.position - EYE.target
    distance = float(np.linalg.norm(away))
    x, y, z = EYE.target.tolist()
    return fl.ThreeDeeCameraState(
        perspective=True,
        distance=round(distance, 3),
        phi=round(float(np.degrees(np.arccos(away[2] / distance))), 2),
        theta_offset=round(float(np.degrees(np.arctan2(-away[0], -away[1]))), 2),
        target=(0, 0, 0),
        target_offset=(x, y, z),
        target_orientation=(0, 0, 0, 1),
        fovy=45,
        near=0.01,
        far=100,
    )


def _plot(plot: Plot) -> fl.PlotConfig:
    series = [
        fl.PlotSeries(
            value=path,
            label=label,
            color=_hex(plot.colors[k % len(plot.colors)]),
            enabled=True,
            timestamp_method="receiveTime",
            show_line=True,
        )
        for k, (path, label) in enumerate(_paths(plot))
    ]
    low, high = plot.span or (None, None)
    return fl.PlotConfig(
        paths=series,
        min_y_value=low,
        max_y_value=high,
        show_legend=len(series) > 1,
        legend_display="floating",
        show_x_axis_labels=True,
        show_y_axis_labels=True,
        is_synced=True,
        x_axis_val="timestamp",
    )


def _paths(plot: Plot) -> Iterator[tuple[str, str]]:
    """Message path and name of each curve. Where a path selects several numbers, Foxglove would
    join them into one curve, so that each gets a path of its own."""
    for selector, names in plot.fields.items():
        if isinstance(names, str):
            yield plot.topic + selector, names
        else:
            for k, name in enumerate(names):
                yield plot.topic + selector.replace("[]", f"[{k}]"), name


def _options(
    title: str,
    config: fl.ThreeDeeConfig | fl.ImageConfig | fl.RawMessagesConfig | fl.PlotConfig,
) -> dict[str, Any]:
    return {**json.loads(config.to_json()), **dict.fromkeys(TITLES, title)}


def _shared(
    direction: Literal["row", "column"],
    places: Sequence[Place],
    shares: Sequence[float] | None = None,
) -> Place:
    """Places one after the other; by default each has as much as the next."""
    first, *rest = places
    if not rest:
        return first
    first_share, *other_shares = shares or [1] * len(places)
    return {
        "direction": direction,
        "first": first,
        "second": _shared(direction, rest, other_shares),
        "splitPercentage": round(100 * first_share / (first_share + sum(other_shares)), 2),
    }


def _hex(color: Color) -> str:
    return "#{:02x}{:02x}{:02x}".format(*color)


if __name__ == "__main__":
    body, out, cameras = wanted(FILE)
    out.write_text(json.dumps(foxglove_layout(body, cameras), indent=2) + "\n", encoding="utf-8")
