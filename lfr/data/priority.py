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


@contextlib.contextmanager
def kept_priority() -> Iterator[None]:
    """Give every thread that has become a real-time one in the body this thread's former policy.

    Nothing happens where the system has no such policies.
    """
    if not hasattr(os, "sched_getscheduler") or not THREADS.is_dir():
        yield
        return
    policy, parameters = os.sched_getscheduler(0), os.sched_getparam(0)
    real_time = set(_real_time())
    try:
        yield
    finally:
        for thread in _real_time():
            if thread not in real_time:
                with contextlib.suppress(OSError):  # it has ended
                    os.sched_setscheduler(thread, policy, parameters)


def _real_time() -> Iterator[int]:
    for entry in THREADS.iterdir():
        with contextlib.suppress(OSError):
            if os.sched_getscheduler(int(entry.name)) in (os.SCHED_FIFO, os.SCHED_RR):
                yield int(entry.name)
