"""Jobs: what repeats (seeds, shards, robots) runs through `run_jobs`, on one core or a cluster.

A job calls a pure function with its specification, so that any process on any machine may run it,
or run it again.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from lfr.artifacts import as_json, fingerprint, read_json, write_json
from lfr.jobs.here import run_here
from lfr.jobs.job import Job
from lfr.jobs.memory import peak_memory
from lfr.jobs.order import Order
from lfr.jobs.results import Results, report
from lfr.progress import progress

__all__ = ["Job", "peak_memory", "report", "run_jobs"]


def run_jobs(
    jobs: Iterable[Job],
    *,
    workers: int | None = None,
    work: Path | None = None,
    description: str = "",
    unit: str = "job",
) -> dict[Job, Any]:
    """The results of all jobs, in their order, each once those that it needs are finished.

    Every job has one thread for its numerical libraries, wherever it runs, so that its result does
    not depend on where. A job whose process is killed is run once more.

    Args:
        jobs: in the order in which they start; each with those that it needs among them.
        workers: processes on this machine; None takes the environment's choice: a Ray cluster if
            ``RAY_ADDRESS`` is set, else one process per core. With 1, or one job left to do
            on this machine, the jobs run in this process.
        work: folder that keeps each result at once, by function and spec, so that a run that is
            killed and started again runs no finished job. Its name must say what else the
            results depend on (`lfr.artifacts.work_folder`).
        description: what the bar says in front.
        unit: what one job is called in the bar.

    Returns:
        Job -> result in JSON's types: tuples come back as lists, NumPy values as numbers.

    Raises:
        LfrError: a job raised it, or its process was killed twice.
        ValueError: a job needs one that is not among ``jobs``.
    """
    jobs = list(dict.fromkeys(jobs))  # each once
    _check_needs(jobs)
    files = {job: work / f"{_fingerprint(job)}.json" for job in jobs} if work else {}
    results = {job: read_json(file)["result"] for job, file in files.items() if file.is_file()}
    todo = [job for job in jobs if job not in results]

    def keep(job: Job, result: Any) -> None:
        results[job] = result
        if files:
            content = {
                "function": _full_name(job.function), "spec": as_json(job.spec), "result": result,
            }  # fmt: skip
            write_json(files[job], content, allow_nan=True)

    with progress(len(jobs), description, unit, initial=len(results)) as bar:
        _run(todo, workers, Results(bar, keep))
    return {job: results[job] for job in jobs}


def _run(todo: list[Job], workers: int | None, results: Results) -> None:
    order = Order(todo)
    if todo and workers is None and os.environ.get("RAY_ADDRESS"):
        from lfr.jobs.cluster import run_on_ray

        return run_on_ray(order, results)
    workers = min(workers or os.cpu_count() or 1, len(todo))
    if workers <= 1:
        return run_here(order, results)
    from lfr.jobs.pool import run_in_pool

    return run_in_pool(order, workers, results)


def _check_needs(jobs: list[Job]) -> None:
    known = set(jobs)
    for job in jobs:
        for missing in (need for need in job.needs if need not in known):
            raise ValueError(
                f"{_full_name(job.function)}({job.spec!r}) needs "
                f"{_full_name(missing.function)}({missing.spec!r}), which is not in this run"
            )


def _fingerprint(job: Job) -> str:
    return fingerprint(_full_name(job.function), job.spec)


def _full_name(function: Callable[[Any], Any]) -> str:
    """Module and name, the same whether the module was imported or is the program itself."""
    module = function.__module__
    spec = getattr(sys.modules.get(module), "__spec__", None)
    return f"{spec.name if spec else module}.{function.__qualname__}"
