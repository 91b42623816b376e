"""Which job comes next: they start in their order, but none before those that it needs."""

from __future__ import annotations

from collections.abc import Iterable

from lfr.jobs.job import Job


class Order:
    """The jobs of one run that wait.

    Args:
        todo: the jobs, in the order in which they start if nothing holds them back; one that is
            needed and is not among them is finished.
    """

    def __init__(self, todo: Iterable[Job]) -> None:
        self._waiting = list(todo)
        self._unfinished = set(self._waiting)

    def __bool__(self) -> bool:
        """Whether a job waits, be it for another one."""
        return bool(self._waiting)

    def next(self) -> Job | None:
        """The next job that may start; None while all of them wait for others."""
        for job in self._waiting:
            if self._unfinished.isdisjoint(job.needs):
                self._waiting.remove(job)
                return job
        return None

    def finish(self, job: Job) -> None:
        """A job is done; those that need it may start."""
        self._unfinished.discard(job)

    def again(self, job: Job) -> None:
        """A job that was started has to be started once more, before the others."""
        self._waiting.insert(0, job)
