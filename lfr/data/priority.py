"""Scheduling priority kept: SVT-AV1, run as root, makes the process that encodes a real-time one.

SVT-AV1 3.0 sets SCHED_FIFO at the highest priority for the thread that opens an encoder and for
its own threads, and leaves it so; what the process starts later inherits it and starves others.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

THREADS = Path("/proc/self/task")
REAL_TIME = {getattr(os, name, None) for name in ("SCHED_FIFO", "SCHED_RR")}


@contextlib.contextmanager
def kept_priority() -> Iterator[None]:
    """Give every thread that the body has made a real-time one its former policy again.

    A thread that began in the body gets that of this thread before it. Nothing happens where the
    system has no such policies.
    """
    if not hasattr(os, "sched_getscheduler") or not THREADS.is_dir():
        yield
        return
    here = _policy(0)
    before = dict(_policies())
    try:
        yield
    finally:
        for thread, now in _policies():
            former = before.get(thread, here)
            if now != former and now[0] in REAL_TIME:
                with contextlib.suppress(OSError):  # it has ended
                    os.sched_setscheduler(thread, former[0], os.sched_param(former[1]))


def _policies() -> Iterator[tuple[int, tuple[int, int]]]:
    for entry in THREADS.iterdir():
        with contextlib.suppress(OSError):
            yield int(entry.name), _policy(int(entry.name))


def _policy(thread: int) -> tuple[int, int]:
    """A thread's policy, and its priority in it."""
    return os.sched_getscheduler(thread), os.sched_getparam(thread).sched_priority
