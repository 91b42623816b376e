"""Memory of this process and of the workers that it has had: the peak, and what is kept of it."""

from __future__ import annotations

import ctypes
import resource
import sys

_UNIT = 1 if sys.platform == "darwin" else 1024  # of ru_maxrss, bytes
_workers = 0

# Parameters of glibc's mallopt (malloc.h) and bytes
_MMAP_THRESHOLD, _TRIM_THRESHOLD, _TOP_PAD = -3, -1, -2
_KEPT = 2**29, 2**25  # before 2.35 glibc takes no more than the second


def keep_freed_memory() -> None:
    """Let this process's allocator reuse what is freed, in place of returning it to the system.

    A training step frees and asks for the same megabytes again; each time the system clears them
    page by page, up to a fifth of the time. Where the C library is not glibc nothing changes.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None and any(mallopt(_MMAP_THRESHOLD, size) for size in _KEPT):
        mallopt(_TRIM_THRESHOLD, _KEPT[0])
        mallopt(_TOP_PAD, 2**26)


def give_back_freed_memory() -> None:
    """Return to the system what this process has freed and its allocator has kept all the same.

    Where the C library is not glibc nothing changes.
    """
    if (trim := getattr(ctypes.CDLL(None), "malloc_trim", None)) is not None:
        trim(0)


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
