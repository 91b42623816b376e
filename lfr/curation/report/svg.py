"""Drawings as inline SVG, in the page's colours: a panel of curves, the episodes' scores."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfr.curation.report.curves import Panel
from lfr.curation.report.words import escaped
from lfr.curation.scores import BEST, Score

Array = NDArray[np.float64]

WIDTH, HEIGHT = 360, 150
LEFT, RIGHT, TOP, BOTTOM = 52, 8, 10, 22  # of the curves, from the edges
MOST = 320  # steps of a curve; of more the highest and the lowest of each are kept
LEAST = 2.5  # width of what is shaded


def drawing(panel: Panel, fps: float, shaded: tuple[int, int] | None, episode: int) -> str:
    """The panel as one `<svg>` element.

    Args:
        panel: what to draw.
        fps: frames per second.
        shaded: first and last frame that it is about.
        episode: for the description.
    """
    count = max(len(line.values) for line in panel.lines)
    low, high = _span(panel)
    seconds = max(count - 1, 1) / fps

    def x(frames: ArrayLike) -> Array:
        return LEFT + (WIDTH - LEFT - RIGHT) * np.asarray(frames, np.float64) / max(count - 1, 1)

    def y(values: ArrayLike) -> Array:
        values = np.asarray(values, np.float64)
        return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * ((values - low) / (high - low))

    said = f"{panel.title} in episode {episode}, {seconds:.3g} s, from {low:.3g} to {high:.3g}"
    if shaded is not None:
        said += f"; shaded: {in_words(shaded)}"
    parts = [f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img"><title>{escaped(said)}</title>']
    for value in (low, (low + high) / 2, high):
        at = float(y(value))
        parts.append(f'<path class="grid" d="M{LEFT} {at:.1f}H{WIDTH - RIGHT}"/>')
        text = _number(value, high - low)
        parts.append(f'<text x="{LEFT - 4}" y="{at + 3:.1f}" class="end">{text}</text>')
    for share, place in ((0.0, "start"), (0.5, "middle"), (1.0, "end")):
        at = LEFT + share * (WIDTH - LEFT - RIGHT)
        text = f"{share * seconds:.3g}" + (" s" if share else "")
        parts.append(f'<text x="{at:.1f}" y="{HEIGHT - 6}" class="{place}">{text}</text>')
    if panel.band is not None:
        frames = np.linspace(0, count - 1, panel.band.shape[1])
        outline = (
            np.concatenate([frames, frames[::-1]]),
            np.concatenate([y(panel.band[2]), y(panel.band[0])[::-1]]),
        )
        parts.append(f'<path class="band" d="{_path(x(outline[0]), outline[1])}Z"/>')
        parts.append(f'<path class="median" d="{_path(x(frames), y(panel.band[1]))}"/>')
    if shaded is not None:
        first, last = x(shaded)
        spare = max(LEAST - (last - first), 0.0)
        parts.append(f'<rect class="shaded" x="{first - spare / 2:.1f}" y="{TOP}" '
                     f'width="{last - first + spare:.1f}" '
                     f'height="{HEIGHT - TOP - BOTTOM}"/>')  # fmt: skip
    for line in panel.lines:
        frames, values = _fewer(line.values)
        parts.append(f'<path class="{line.role}" d="{_path(x(frames), y(values))}"/>')
    return "".join([*parts, "</svg>"])


def in_words(frames: tuple[int, int]) -> str:
    """`frame 3`, or `frames 3 to 5`."""
    first, last = frames
    return f"frame {first}" if first == last else f"frames {first} to {last}"


def squares(scores: Sequence[Score]) -> str:
    """A square for each episode, row by row, in the colour of its score."""
    across = max(10, min(60, round((4 * len(scores)) ** 0.5)))
    down = -(-len(scores) // across)
    said = f"The score of each episode, {across} in a row"
    parts = [f'<svg class="squares" viewBox="0 0 {10 * across} {10 * down}" role="img" '
             f'style="max-width:{16 * across}px"><title>{said}</title>']  # fmt: skip
    for score in scores:
        x, y = score.episode % across, score.episode // across
        level = "s0" if score.score == 0 else "s1" if score.score == BEST else "s2"
        words = f"episode {score.episode}, score {score.score:g}"
        words += f": {', '.join(score.kinds)}" if score.kinds else ""
        parts.append(f'<rect class="{level}" x="{10 * x}" y="{10 * y}" width="9" height="9">'
                     f"<title>{escaped(words)}</title></rect>")  # fmt: skip
    keys = {"s1": "nothing found", "s2": "warnings", "s0": "an error"}
    legend = " ".join(f'<span class="key {level}">{text}</span>' for level, text in keys.items())
    return "".join([*parts, f'</svg><p class="legend">{legend}</p>'])


def _span(panel: Panel) -> tuple[float, float]:
    """The lowest and the highest that is drawn, somewhat apart."""
    every = [line.values for line in panel.lines]
    if panel.band is not None:
        every.append(panel.band.ravel())
    values = np.concatenate(every)
    values = values[np.isfinite(values)]
    if not len(values):
        return -1.0, 1.0
    low, high = float(values.min()), float(values.max())
    apart = (high - low) / 2 or max(abs(high) / 10, 1e-6)
    return low - apart / 10, high + apart / 10


def _number(value: float, span: float) -> str:
    """A value to a hundredth of what is drawn: 0 is 0 there."""
    place = 2 - math.floor(math.log10(span))
    rounded = round(value, place) + 0.0  # no -0
    digits = 6 if abs(rounded) < 1e6 else 3
    return f"{rounded:.{digits}g}"


def _fewer(values: Array) -> tuple[Array, Array]:
    """Frames and values of a curve, no more than can be seen, spikes kept."""
    frames = np.arange(len(values), dtype=np.float64)
    if len(values) <= 2 * MOST:
        return frames, values
    kept: list[int] = []
    for part in np.array_split(np.arange(len(values)), MOST):
        some = values[part]
        ends = {int(np.argmin(some)), int(np.argmax(some))}  # a gap is both
        kept += [int(part[i]) for i in sorted(ends)]
    return frames[kept], values[kept]


def _path(x: Array, y: Array) -> str:
    """Straight lines through the points, interrupted where there is no number."""
    steps, down = [], False
    for at, value in zip(np.atleast_1d(x), np.atleast_1d(y), strict=True):
        if np.isfinite(value):
            steps.append(f"{'L' if down else 'M'}{at:.1f} {value:.1f}")
        down = bool(np.isfinite(value))
    return "".join(steps)
