"""Jobs: what repeats (seeds, shards, robots) runs through `run_jobs`, on one core or a cluster.

A job is a pure function of its specification, at the top level of a module, so that any process
on any machine may run it, or run it again.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from lfr.artifacts import as_json, fingerprint, read_json, write_json
from lfr.jobs.here import run_here
from lfr.jobs.memory import peak_memory
from lfr.jobs.order import Order
from lfr.jobs.results import Results, report
from lfr.progress import progress

__all__ = ["peak_memory", "report", "run_jobs"]


def run_jobs(
    function: Callable[[Any], Any],
    specs: Sequence[Any],
    *,
    after: Mapping[int, int] = MappingProxyType({}),
    workers: int | None = None,
    work: Path | None = None,
    description: str = "",
    unit: str = "job",
) -> list[Any]:
    """The results of ``function(spec)`` for every spec, in the order of ``specs``.

    Every job has one thread for its numerical libraries, wherever it runs, so that its result does
    not depend on where. A job whose process is killed is run once more.

    Args:
        function: picklable, without side effects that may not happen twice. Inside, it may call
            `report` to move the bar.
        specs: values that JSON can hold, or dataclasses of such.
        after: number of a job -> number of the one that must be finished before it starts, because
            it reads what that one wrote.
        workers: processes on this machine; None takes the environment's choice: a Ray cluster if
            ``RAY_ADDRESS`` is set, else one process per core. With 1, or one job left to do
            on this machine, the jobs run in this process.
        work: folder that keeps each result at once, by function and spec, so that a run that is
            killed and started again runs no finished job. Its name must say what else the
            results depend on (`lfr.artifacts.work_folder`).
        description: what the bar says in front.
        unit: what one job is called in the bar.

    Returns:
        The results in JSON's types: tuples come back as lists, NumPy values as numbers.

    Raises:
        LfrError: a job raised it, or its process was killed twice.
    """
    name = _full_name(function)
    files = [work / f"{fingerprint(name, spec)}.json" for spec in specs] if work else []
    results = {i: read_json(file)["result"] for i, file in enumerate(files) if file.is_file()}
    todo = {i: spec for i, spec in enumerate(specs) if i not in results}

    def keep(index: int, result: Any) -> None:
        results[index] = result
        if files:
            content = {"function": name, "spec": as_json(specs[index]), "result": result}
            write_json(files[index], content, allow_nan=True)

    with progress(len(specs), description, unit, initial=len(results)) as bar:
        _run(function, todo, after, workers, Results(bar, keep))
    return [results[index] for index in range(len(specs))]


def _run(
    function: Callable[[Any], Any],
    todo: Mapping[int, Any],
    after: Mapping[int, int],
    workers: int | None,
    results: Results,
) -> None:
    order = Order(todo, after)
    if todo and workers is None and os.environ.get("RAY_ADDRESS"):
        from lfr.jobs.cluster import run_on_ray

        return run_on_ray(function, todo, order, results)
    workers = min(workers or os.cpu_count() or 1, len(todo))
    if workers <= 1:
        return run_here(function, todo, order, results)
    from lfr.jobs.pool import run_in_pool

    return run_in_pool(function, todo, order, workers, results)


def _full_name(function: Callable[[Any], Any]) -> str:
    """Module and name, the same whether the module was imported or is the program itself."""
    module = function.__module__
    spec = getattr(sys.modules.get(module), "__spec__", None)
    return f"{spec.name if spec else module}.{function.__qualname__}"
