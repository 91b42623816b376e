"""A job: a function, what it is called with, and the jobs whose work it reads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, eq=False)
class Job:
    """One call of a function, and what must be finished before.

    A job is itself and no other, even one of the same function and spec, so that results are looked
    up by it. It is frozen, and what it needs is there before it: jobs cannot wait for each other in
    a circle.

    Attributes:
        function: at the top level of a module, without side effects that may not happen twice.
            Inside, it may call `lfr.jobs.report` to move the bar.
        spec: its one argument: a value that JSON can hold, or a dataclass of such.
        needs: the jobs that must be finished before this one starts, because it reads what they
            wrote; it is not handed their results.
    """

    function: Callable[[Any], Any]
    spec: Any
    needs: tuple[Job, ...] = ()
