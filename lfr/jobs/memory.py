"""Peak memory of this process and of the workers that it has had."""

from __future__ import annotations

import resource
import sys

_UNIT = 1 if sys.platform == "darwin" else 1024  # of ru_maxrss, bytes
_workers = 0


def peak_memory() -> int:
    """Bytes: the most that any one process of this program has had in main memory so far.

    That is this process, and the workers of `lfr.jobs.run_jobs` on this machine as far as they have
    ended a job; tasks on a Ray cluster are not counted.
    """
    return max(own_peak(), _workers)


def own_peak() -> int:
    """Bytes: the most that this process has had in main memory so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _UNIT


def note_worker(peak: int) -> None:
    """Remember a worker's `own_peak`: it is no child of this process, which cannot ask for it."""
    global _workers
    _workers = max(_workers, peak)
