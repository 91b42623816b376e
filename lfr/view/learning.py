"""A learning run's curves in rerun: from its curve on disk, or live while it learns.

Entities, on the timeline `env_steps` (control steps executed, warm-up included):

    /evaluation/success, /return, /length   the policy's mean, at each evaluation
    /learning/success                       of the episodes learned from, between evaluations
    /update/kl, /alpha, /sigma, /q, /critic_loss, /policy_loss
"""

from __future__ import annotations

import csv
import dataclasses
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lfr.artifacts import read_json, write_whole
from lfr.errors import DataError
from lfr.transfer.observer import CurvePoint, Observer
from lfr.view import series
from lfr.view.scene import APPLICATION

if TYPE_CHECKING:
    import rerun as rr

Point = Mapping[str, Any]

CURVES: dict[str, tuple[str, str, series.Color]] = {
    "success": ("/evaluation/success", "evaluation", series.GREEN),
    "mean_return": ("/evaluation/return", "return", series.VIOLET),
    "mean_length": ("/evaluation/length", "length", series.GREY),
    "learning_success": ("/learning/success", "while learning", series.GREY),
}
UPDATES: dict[str, tuple[str, str, series.Color]] = {
    "kl": ("/update/kl", "KL", series.TEAL),
    "alpha": ("/update/alpha", "alpha", series.AMBER),
    "sigma": ("/update/sigma", "sigma", series.BLUE),
    "q": ("/update/q", "Q", series.VIOLET),
    "critic_loss": ("/update/critic_loss", "critic", series.RED),
    "policy_loss": ("/update/policy_loss", "policy", series.AMBER),
}
"""Quantity of a curve -> its entity, its name in the legend, its colour."""

FLUSH_SECONDS = 2.0


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


def save_learning(path: Path, curve: Sequence[Point], title: str) -> None:
    """Write a curve and its blueprint to an `.rrd` file, whole."""
    with write_whole(path) as partial:
        recording = _recording(partial, title)
        log_curve(recording, curve, {**CURVES, **UPDATES})
        recording.flush()
        recording.disconnect()


def log_curve(
    recording: rr.RecordingStream,
    curve: Iterable[Point],
    quantities: Mapping[str, tuple[str, str, series.Color]] = CURVES,
) -> None:
    """Log what the points hold of the given quantities; None and absent values leave gaps."""
    import rerun as rr

    points = list(curve)
    for key, (path, _, _) in quantities.items():
        held = [point for point in points if point.get(key) is not None]
        if held:
            steps = rr.TimeColumn("env_steps", sequence=[int(p["env_steps"]) for p in held])
            columns = rr.Scalars.columns(scalars=[float(p[key]) for p in held])
            recording.send_columns(path, indexes=[steps], columns=columns)


class LearningLog(Observer):
    """Listens to a learning run and writes what it hears to an `.rrd` file, live.

    Updates are kept in lists and sent every two seconds as columns, which costs some microseconds
    an update; the file can be followed while it grows (`lfr view`). It is complete after `close`.

    Args:
        path: the file.
        title: what the viewer calls the recording.
        sample: called with the environment steps at each evaluation listed in `samples`, to leave
            an episode to look at; it may not draw from the run's random numbers.
        samples: fractions of the run after which `sample` is called at the next evaluation.
        on_progress: told `env_steps` and their total, for a progress bar.
    """

    def __init__(
        self,
        path: Path,
        title: str,
        sample: Callable[[int], None] | None = None,
        samples: Sequence[float] = (0.0, 0.5, 1.0),
        on_progress: Callable[[int, int], None] | None = None,
    ) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._recording = _recording(path, title)
        self._updates: list[dict[str, float]] = []
        self._seen: set[int] = set()
        self._sent = time.monotonic()
        self._sample, self._waiting = sample, sorted(samples)
        self._fraction = 0.0
        self._report = on_progress

    def on_update(self, env_steps: int, updates: int, info: Mapping[str, float]) -> None:
        self._updates.append({"env_steps": env_steps, **info})
        if time.monotonic() - self._sent > FLUSH_SECONDS:
            self.send()

    def on_evaluation(self, point: CurvePoint) -> None:
        self.catch_up([dataclasses.asdict(point)])
        if self._waiting and self._fraction >= self._waiting[0]:
            self._waiting = [part for part in self._waiting if part > self._fraction]
            if self._sample is not None:
                self._sample(point.env_steps)

    def on_progress(self, env_steps: int, total: int) -> None:
        self._fraction = env_steps / total
        if self._report is not None:
            self._report(env_steps, total)

    def catch_up(self, curve: Iterable[Point]) -> None:
        """Log the points of a curve that were not heard of, as those before a run was resumed."""
        new = [point for point in curve if int(point["env_steps"]) not in self._seen]
        self._seen.update(int(point["env_steps"]) for point in new)
        log_curve(self._recording, new)
        self.send()

    def send(self) -> None:
        """Send what is kept, so that whoever follows the file sees it."""
        log_curve(self._recording, self._updates, UPDATES)
        self._updates.clear()
        self._sent = time.monotonic()

    def close(self) -> None:
        """Send what is kept and finish the file."""
        self.send()
        self._recording.flush()
        self._recording.disconnect()


def _recording(path: Path, title: str) -> rr.RecordingStream:
    import rerun as rr

    from lfr.view.blueprint import learning_blueprint

    recording = rr.RecordingStream(APPLICATION)
    recording.save(path, default_blueprint=learning_blueprint())
    recording.send_recording_name(title)
    for entity, name, color in (*CURVES.values(), *UPDATES.values()):
        style = rr.SeriesLines(names=[name], colors=[color], widths=[2.0])
        recording.log(entity, style, static=True)
    return recording
