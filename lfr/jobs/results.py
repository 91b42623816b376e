"""How far the jobs are: what they report from inside, and what they gave."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from typing import Any

from tqdm import tqdm

from lfr.jobs.job import Job

REPORT_INTERVAL = 0.2  # seconds between two reports that go on; a job may call as often as it likes

Send = Callable[[float], None]


class _Listener:
    """Passes a job's fraction on, now and then."""

    def __init__(self, send: Send) -> None:
        self._send = send
        self._next = 0.0

    def __call__(self, fraction: float) -> None:
        now = time.monotonic()
        if now >= self._next:
            self._next = now + REPORT_INTERVAL
            self._send(fraction)


_listener: ContextVar[_Listener | None] = ContextVar("_listener", default=None)


def report(done: float, total: float) -> None:
    """Say, from inside a job, that it has done ``done`` of ``total``: the bar moves by the share.

    Costs less than a microsecond between two reports that go on. Outside a job it does nothing.
    """
    listener = _listener.get()
    if listener is not None and total > 0:
        listener(min(max(done / total, 0.0), 1.0))


@contextlib.contextmanager
def listening(send: Send) -> Iterator[None]:
    """While it lasts, `report` goes to ``send`` as a fraction between 0 and 1."""
    token = _listener.set(_Listener(send))
    try:
        yield
    finally:
        _listener.reset(token)


class Results:
    """Moves the bar by the sum of all jobs' fractions and hands finished results on."""

    def __init__(self, bar: tqdm, keep: Callable[[Job, Any], None]) -> None:
        self._bar = bar
        self._keep = keep
        self._before = bar.n  # results of an earlier run
        self._finished = 0
        self._fractions: dict[Job, float] = {}

    def report(self, job: Job, fraction: float) -> None:
        """A job has come this far; one that starts again goes back."""
        self._fractions[job] = fraction
        self._draw()

    def finish(self, job: Job, result: Any) -> None:
        """A job has ended with this result, in JSON's types."""
        self._keep(job, result)
        self._fractions.pop(job, None)
        self._finished += 1
        self._draw()

    def _draw(self) -> None:
        done = self._before + self._finished + sum(self._fractions.values())
        whole = not self._fractions
        self._bar.n = round(done) if whole else round(done, 2)
        self._bar.update(0)  # draws only if it is time to
