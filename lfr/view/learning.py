"""A learning run in rerun, live while it learns: it listens to the run and writes its curves."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from lfr.transfer.observer import CurvePoint, Observer
from lfr.view.curve import CURVES, UPDATES, Point, learning_recording, log_curve

FLUSH_SECONDS = 2.0


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
        self._recording = learning_recording(path, title, choice=True)
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
        self._seen.add(point.env_steps)
        log_curve(self._recording, [dataclasses.asdict(point)])
        self.send()
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
        # Their updates were not heard of either; a point holds the means.
        log_curve(self._recording, new, {**CURVES, **UPDATES})
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
