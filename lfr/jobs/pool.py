"""Jobs in processes on this machine.

Workers are forked from a fresh server process, not from this one: libraries here may have threads
running (OpenMP, rerun, Arrow) or OpenGL contexts open, and a fork of these hangs or crashes. Each
worker is spoken to over a pipe of its own, so that the death of one costs one job one attempt;
`concurrent.futures` gives up all of its processes then, and cannot pass reports from inside a job.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import traceback
from collections import Counter
from multiprocessing import connection, forkserver, get_context, parent_process
from multiprocessing.connection import Connection
from typing import Any

from lfr.artifacts import as_json
from lfr.errors import LfrError
from lfr.jobs.here import one_thread
from lfr.jobs.job import Job
from lfr.jobs.memory import keep_freed_memory, note_worker, own_peak
from lfr.jobs.order import Order
from lfr.jobs.results import Results, listening

ATTEMPTS = 2
STOP_TIMEOUT = 2.0  # seconds to end on SIGTERM before SIGKILL


def run_in_pool(order: Order, workers: int, results: Results) -> None:
    """Run the jobs in ``workers`` processes; a job whose process dies is tried once more.

    Raises:
        LfrError: a job raised it, or its process died twice.
        OSError: a job raised it.
        RuntimeError: a job raised anything else; the message holds its traceback.
    """
    attempts: Counter[Job] = Counter()
    idle = [_Worker() for _ in range(workers)]
    busy: dict[Connection, _Worker] = {}
    try:
        while order or busy:
            while idle and (job := order.next()) is not None:
                worker = idle.pop()
                attempts[job] += 1
                worker.start(job)
                busy[worker.pipe] = worker
            ready = connection.wait(busy)
            for worker in [busy[pipe] for pipe in list(busy) if pipe in ready]:
                kind, value = worker.receive()
                if kind == "report":
                    results.report(worker.job, value)
                    continue
                if kind == "memory":
                    note_worker(value)
                    continue
                del busy[worker.pipe]
                if kind == "result":
                    results.finish(worker.job, value)
                    order.finish(worker.job)
                    idle.append(worker)
                elif kind == "error":
                    idle.append(worker)
                    raise value
                else:
                    worker.stop()
                    idle.append(_Worker())
                    if attempts[worker.job] == ATTEMPTS:
                        raise LfrError(_death(worker.job.spec, worker.process.exitcode))
                    results.report(worker.job, 0.0)
                    order.again(worker.job)
    finally:
        for worker in [*idle, *busy.values()]:
            worker.process.terminate()
        for worker in [*idle, *busy.values()]:
            worker.stop()


class _Worker:
    """A process, this end of its pipe, and the job that it was last given."""

    job: Job

    def __init__(self) -> None:
        self.pipe, theirs = connection.Pipe()
        context = get_context("forkserver")
        with one_thread():  # the workers' environment is the server's
            forkserver.set_forkserver_preload([__name__])  # once, not in each worker
            forkserver.ensure_running()
        self.process = context.Process(target=_work, args=(theirs,), daemon=True)
        self.process.start()
        theirs.close()  # so that the pipe ends when the worker does

    def start(self, job: Job) -> None:
        self.job = job
        with contextlib.suppress(OSError):  # it died while idle; `receive` says so
            self.pipe.send((job.function, job.spec))

    def receive(self) -> tuple[str, Any]:
        try:
            return self.pipe.recv()
        except (EOFError, OSError):
            return "death", None

    def stop(self) -> None:
        self.process.join(STOP_TIMEOUT)
        if self.process.exitcode is None:
            self.process.kill()
            self.process.join()
        self.pipe.close()


def _work(pipe: Connection) -> None:
    """A worker's life: run jobs until the pipe ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the parent, which ends us
    threading.Thread(target=_end_with_parent, daemon=True).start()
    keep_freed_memory()
    with listening(lambda fraction: pipe.send(("report", fraction))):
        while True:
            try:
                function, spec = pipe.recv()
            except EOFError:
                return
            try:
                answer = "result", as_json(function(spec))
            except (LfrError, OSError) as error:
                answer = "error", error
            except Exception:  # whatever it is, the parent raises it where the user sees it
                answer = "error", RuntimeError(f"job {spec!r} failed\n{traceback.format_exc()}")
            pipe.send(("memory", own_peak()))
            pipe.send(answer)


def _end_with_parent() -> None:
    """Leave no orphan that works on beside a run that is started again."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _death(spec: Any, exitcode: int | None) -> str:
    cause = f"exit code {exitcode}"
    if exitcode is not None and exitcode < 0:
        cause = signal.Signals(-exitcode).name
    advice = "; is there enough memory? try fewer workers" if cause == "SIGKILL" else ""
    return f"the process of job {spec!r} died {ATTEMPTS} times ({cause}){advice}"
