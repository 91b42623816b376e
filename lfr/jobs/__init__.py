"""Jobs: what repeats (seeds, shards, episodes) runs through `run_jobs`, on one core or a cluster."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import os

from lfr.artifacts import fingerprint, read_json, write_json
from lfr.progress import progress


def report(done: float, total: float) -> None:
    """Say, from inside a job, that it has done ``done`` of ``total``; the bar moves by it."""


def run_jobs(
    function: Callable[[Any], Any],
    specs: Sequence[Any],
    *,
    workers: int | None = None,
    work: Path | None = None,
    description: str = "",
    unit: str = "job",
) -> list[Any]:
    """(first version) The results of ``function`` over ``specs``, in their order."""
    files = [
        work and work / f"{fingerprint(function.__qualname__, spec)}.json" for spec in specs
    ]
    results: dict[int, Any] = {i: read_json(f) for i, f in enumerate(files) if f and f.exists()}
    todo = [i for i in range(len(specs)) if i not in results]
    workers = min(workers or os.cpu_count() or 1, len(todo))
    with progress(len(specs), description, unit) as bar:
        bar.update(len(results))
        if workers <= 1:
            outcomes = ((i, function(specs[i])) for i in todo)
            for i, result in outcomes:
                _keep(files[i], result)
                results[i] = result
                bar.update(1)
        else:
            with ProcessPoolExecutor(workers, mp_context=get_context("forkserver")) as pool:
                for i, result in zip(todo, pool.map(function, [specs[i] for i in todo])):
                    _keep(files[i], result)
                    results[i] = result
                    bar.update(1)
    return [results[i] for i in range(len(specs))]


def _keep(file: Path | None, result: Any) -> None:
    if file:
        write_json(file, result)
