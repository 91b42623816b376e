"""A panel of a latent space: a bar for each Gaussian in each dimension, and points.

Dimensions stand side by side, z upwards. rerun has no such chart, so that it is drawn as lines and
points of a 2-D scene whose y axis points down.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfr.view.series import Color

if TYPE_CHECKING:
    import rerun as rr

DIMENSION_WIDTH, UNIT = 62.0, 40.0
"""Scene units per latent dimension (to the right) and per 1.0 of z (upwards)."""

SPAN = 3.0
"""A panel shows z in [-SPAN, SPAN]: the VAE's prior is a standard normal distribution."""

LABEL_DROP = 0.3
"""How far below its point a label appears in a panel of usual size, in units of z."""


def bounds(dims: int) -> tuple[tuple[float, float], tuple[float, float]]:
    """What shows a panel of `dims` dimensions whole: its horizontal and its vertical range."""
    x = (-1.1 * DIMENSION_WIDTH, (dims - 0.4) * DIMENSION_WIDTH)
    return x, (-(SPAN + 1.2) * UNIT, (SPAN + 1.0) * UNIT)


def log_gaussian(
    recording: rr.RecordingStream,
    path: str,
    times: list[rr.TimeColumn],
    mu: NDArray[np.floating],
    log_sigma: NDArray[np.floating],
    color: Color,
    offset: float,
) -> None:
    """A bar from mu - sigma to mu + sigma in each dimension (K, Z), and a dark dot at mu.

    `offset` moves it to the right, in scene units, so that several stand side by side.
    """
    import rerun as rr

    low, high = (_place(mu + sign * np.exp(log_sigma), offset) for sign in (-1, 1))
    strips = np.stack([low, high], axis=2)  # (K, Z, 2 ends, 2)
    count, dims = mu.shape
    style = rr.LineStrips2D.from_fields(colors=color, radii=5.0)
    recording.log(f"{path}/spread", style, static=True)
    columns = rr.LineStrips2D.columns(strips=list(strips.reshape(count * dims, 2, 2)))
    recording.send_columns(
        f"{path}/spread", indexes=times, columns=columns.partition([dims] * count)
    )
    dark = (color[0] // 3, color[1] // 3, color[2] // 3)
    log_points(recording, f"{path}/mean", times, mu, dark, offset, 2.6)


def log_points(
    recording: rr.RecordingStream,
    path: str,
    times: list[rr.TimeColumn],
    values: NDArray[np.floating],
    color: Color,
    offset: float,
    radius: float,
    order: float = 40.0,
) -> None:
    """A dot at each value (K, Z), in scene units; a higher `order` is drawn over a lower one."""
    import rerun as rr

    count, dims = values.shape
    style = rr.Points2D.from_fields(colors=color, radii=radius, draw_order=order)
    recording.log(path, style, static=True)
    positions = _place(values, offset).reshape(-1, 2)
    columns = rr.Points2D.columns(positions=positions).partition([dims] * count)
    recording.send_columns(path, indexes=times, columns=columns)


def _place(values: NDArray[np.floating], offset: float) -> NDArray[np.float64]:
    """Where values (K, Z) of z stand in a panel, (K, Z, 2); its y axis points down."""
    x = np.arange(values.shape[1]) * DIMENSION_WIDTH + offset
    y = -np.clip(values, -SPAN, SPAN) * UNIT
    return np.stack([np.broadcast_to(x, y.shape), y], axis=-1).astype(np.float64)


def log_axes(recording: rr.RecordingStream, path: str, dims: int, legend: dict[str, Color]) -> None:
    """Lines at whole values of z, named, the number of each dimension below, a legend above."""
    import rerun as rr

    left, right = -0.5 * DIMENSION_WIDTH, (dims - 0.5) * DIMENSION_WIDTH
    levels = np.arange(-SPAN, SPAN + 1)
    lines = [np.array([(left, -level * UNIT), (right, -level * UNIT)]) for level in levels]
    shades = [(110, 116, 128) if level == 0 else (52, 57, 67) for level in levels]
    grid = rr.LineStrips2D(lines, colors=shades, radii=0.5, draw_order=-10.0)
    recording.log(f"{path}/grid", grid, static=True)
    # rerun writes a label below its point: the point stands that much higher.
    marks = [(left - 14, -(level + LABEL_DROP) * UNIT) for level in levels]
    bottom = (SPAN + 0.5 - LABEL_DROP) * UNIT
    marks += [(d * DIMENSION_WIDTH, bottom) for d in range(dims)]
    words = [f"{level:+.0f}" if level else "0" for level in levels]
    words += [f"z{d}" for d in range(dims)]
    text = rr.Points2D(
        np.array(marks),
        labels=words,
        show_labels=True,
        radii=0.01,
        colors=(150, 155, 165),
        draw_order=-5.0,
    )
    recording.log(f"{path}/names", text, static=True)
    step = (right - left) / len(legend)
    keys = [(left + step * (k + 0.5), -(SPAN + 0.9) * UNIT) for k in range(len(legend))]
    named = rr.Points2D(
        keys, labels=list(legend), show_labels=True, radii=5.0, colors=list(legend.values())
    )
    recording.log(f"{path}/legend", named, static=True)
