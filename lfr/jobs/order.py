"""Which job comes next: they start in their order, but none before the one that it needs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping


class Order:
    """The jobs of one run that wait, by number.

    Args:
        todo: the jobs, in the order in which they start if nothing holds them back.
        after: job -> the one that must be finished first; one that is not in ``todo`` is.
    """

    def __init__(self, todo: Iterable[int], after: Mapping[int, int]) -> None:
        self._waiting = list(todo)
        self._unfinished = set(self._waiting)
        self._after = after

    def __bool__(self) -> bool:
        """Whether a job waits, be it for another one."""
        return bool(self._waiting)

    def next(self) -> int | None:
        """The next job that may start; None while all of them wait for others."""
        for index in self._waiting:
            if self._after.get(index) not in self._unfinished:
                self._waiting.remove(index)
                return index
        return None

    def finish(self, index: int) -> None:
        """A job is done; those that need it may start."""
        self._unfinished.discard(index)

    def again(self, index: int) -> None:
        """A job that was started has to be started once more, before the others."""
        self._waiting.insert(0, index)
