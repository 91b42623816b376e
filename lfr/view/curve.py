"""The curves of learning runs: read from disk, told apart by their seeds, and drawn.

Entities, on the timeline `env_steps` (control steps executed, warm-up included):

    /evaluation/success, /return, /length   the policy's mean, at each evaluation
    /learning/success                       of the episodes learned from, between evaluations
    /update/kl, /alpha, /sigma, /q, /critic_loss, /policy_loss

Where a file holds runs of several seeds, each has an entity below these: `/update/kl/seed-3`.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lfr.artifacts import read_json, write_whole
from lfr.errors import DataError
from lfr.view import series
from lfr.view.blueprint import learning_blueprint

if TYPE_CHECKING:
    import rerun as rr

Point = Mapping[str, Any]


@dataclass(frozen=True)
class Quantity:
    """How a quantity of a curve is drawn.

    Attributes:
        entity: that it is logged to.
        name: in the legend.
        color: of a run alone; several runs have a colour each.
        width: of the line, in points.
    """

    entity: str
    name: str
    color: series.Color
    width: float = 2.0


CURVES = {
    "success": Quantity("/evaluation/success", "evaluation", series.GREEN),
    "mean_return": Quantity("/evaluation/return", "return", series.VIOLET),
    "mean_length": Quantity("/evaluation/length", "length", series.TEAL),
    "learning_success": Quantity("/learning/success", "while learning", series.GREY, 1.0),
}
"""What an evaluation says."""

UPDATES = {
    "kl": Quantity("/update/kl", "KL", series.TEAL),
    "alpha": Quantity("/update/alpha", "alpha", series.AMBER),
    "sigma": Quantity("/update/sigma", "sigma", series.BLUE),
    "q": Quantity("/update/q", "Q", series.VIOLET),
    "critic_loss": Quantity("/update/critic_loss", "critic", series.RED),
    "policy_loss": Quantity("/update/policy_loss", "policy", series.AMBER),
}
"""What an update says, or the mean of those before an evaluation."""


def read_curve(path: Path) -> list[Point]:
    """The points of a curve on disk: JSON (a list, or an object with `curve`) or CSV.

    Raises:
        DataError: the file is missing, is no curve, or has no column `env_steps`.
    """
    if path.suffix == ".csv":
        if not path.is_file():
            raise DataError("the file is missing", file=path)
        with path.open(newline="", encoding="utf-8") as stream:
            points: Any = [
                {key: float(text) if text else None for key, text in row.items()}
                for row in csv.DictReader(stream)
            ]
    else:
        content = read_json(path)
        points = content.get("curve") if isinstance(content, dict) else content
    if not isinstance(points, list) or not points:
        raise DataError("no curve of a learning run", file=path, expected="a list of points")
    for point in points:
        if not isinstance(point, dict) or "env_steps" not in point:
            raise DataError("no curve of a learning run", file=path, column="env_steps")
    return points


def runs_of(curve: Iterable[Point]) -> dict[str, list[Point]]:
    """The points of each run, by the name `seed-<n>`; of a single run, by the empty name."""
    runs: dict[str, list[Point]] = {}
    for point in curve:
        seed = point.get("seed")
        runs.setdefault("" if seed is None else f"seed-{int(seed)}", []).append(point)
    return runs if len(runs) > 1 else {"": next(iter(runs.values()), [])}


def save_learning(path: Path, curve: Sequence[Point], title: str) -> None:
    """Write the curve of a run, or those of several, and the blueprint to an `.rrd` file, whole."""
    runs = runs_of(curve)
    with write_whole(path) as partial:
        recording = learning_recording(partial, title, list(runs))
        for run, points in runs.items():
            log_curve(recording, points, {**CURVES, **UPDATES}, run)
        recording.flush()
        recording.disconnect()


def learning_recording(
    path: Path, title: str, runs: Sequence[str] = ("",), *, choice: bool = False
) -> rr.RecordingStream:
    """A recording to the file at `path`, with its blueprint and the style of every curve."""
    import rerun as rr

    recording = rr.RecordingStream(title)
    recording.save(path, default_blueprint=learning_blueprint(title, choice=choice))
    recording.send_recording_name(f"learning · {title}")
    for number, run in enumerate(runs):
        color = series.PALETTE[number % len(series.PALETTE)]
        for quantity in (*CURVES.values(), *UPDATES.values()):
            style = rr.SeriesLines(
                names=[f"{run.replace('-', ' ')}, {quantity.name}" if run else quantity.name],
                colors=[color if run else quantity.color],
                widths=[quantity.width],
            )
            recording.log(_entity(quantity, run), style, static=True)
    return recording


def log_curve(
    recording: rr.RecordingStream,
    curve: Iterable[Point],
    quantities: Mapping[str, Quantity] = CURVES,
    run: str = "",
) -> None:
    """Log what the points of a run hold of the quantities; None and absent values leave gaps."""
    import rerun as rr

    points = list(curve)
    for key, quantity in quantities.items():
        held = [point for point in points if point.get(key) is not None]
        if held:
            steps = rr.TimeColumn("env_steps", sequence=[int(p["env_steps"]) for p in held])
            columns = rr.Scalars.columns(scalars=[float(p[key]) for p in held])
            recording.send_columns(_entity(quantity, run), indexes=[steps], columns=columns)


def _entity(quantity: Quantity, run: str) -> str:
    return f"{quantity.entity}/{run}" if run else quantity.entity
