"""Jobs on a Ray cluster (optional extra ``cluster``).

The nodes need the project's folder under the same path (a shared file system) and its environment:
the jobs read datasets and keep checkpoints there, so a job whose node dies goes on elsewhere.
"""

from __future__ import annotations

import logging
import os
import socket
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from lfr.artifacts import as_json
from lfr.errors import LfrError, MissingLibraryError
from lfr.jobs.here import one_thread
from lfr.jobs.job import Job
from lfr.jobs.memory import keep_freed_memory
from lfr.jobs.order import Order
from lfr.jobs.results import Results, listening

RETRIES = 3  # of a job whose worker or node died; what a job raises itself is never retried
POLL = 0.5  # seconds between two looks at the reports


def run_on_ray(order: Order, results: Results) -> None:
    """Run the jobs as Ray tasks of one core each, at the cluster of ``RAY_ADDRESS``.

    Raises:
        LfrError: a job raised it, its worker died too often, or no cluster answers.
        MissingLibraryError: Ray is not installed.
    """
    ray = _connect()
    board = ray.remote(num_cpus=0)(_Board).remote()
    task = ray.remote(num_cpus=1, max_retries=RETRIES)(_on_node)
    folder = os.getcwd()
    started: list[Job] = []
    pending: dict[Any, Job] = {}
    try:
        while order or pending:
            while (job := order.next()) is not None:
                reference = task.remote(folder, job.function, job.spec, len(started), board)
                started.append(job)
                pending[reference] = job
            ready, _ = ray.wait(list(pending), timeout=POLL)
            for number, fraction in ray.get(board.take.remote()).items():
                results.report(started[number], fraction)
            for reference in ready:
                results.finish(pending[reference], ray.get(reference))
                order.finish(pending.pop(reference))
    except ray.exceptions.RayTaskError as error:
        if isinstance(error.cause, LfrError):
            raise error.cause from None
        raise RuntimeError(str(error)) from None  # its text is the traceback on the node
    except ray.exceptions.RayError as error:
        raise LfrError(f"a job was lost on the Ray cluster: {_one_line(error)}") from None
    finally:
        for reference in pending:
            ray.cancel(reference, force=True)
        ray.kill(board)


class _Board:
    """An actor that collects what running jobs, by number, report until it is taken."""

    def __init__(self) -> None:
        self._fractions: dict[int, float] = {}

    def put(self, number: int, fraction: float) -> None:
        self._fractions[number] = fraction

    def take(self) -> dict[int, float]:
        taken, self._fractions = self._fractions, {}
        return taken


def _on_node(
    folder: str, function: Callable[[Any], Any], spec: Any, number: int, board: Any
) -> Any:
    """Run one job on the node that it fell to, in the project's folder there."""
    if not Path(folder).is_dir():
        node = os.uname().nodename
        raise LfrError(f"node {node} has no folder {folder}; share the project's folder with it")
    os.chdir(folder)
    keep_freed_memory()
    with one_thread(), listening(partial(board.put.remote, number)):
        return as_json(function(spec))


def _connect() -> Any:
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    # One job's error is raised here; those of the jobs cancelled with it are not.
    os.environ.setdefault("RAY_IGNORE_UNHANDLED_ERRORS", "1")
    try:
        import ray
        import ray.exceptions
    except ImportError:
        raise MissingLibraryError(
            "RAY_ADDRESS is set, but Ray is not installed; install lfr with its extra `cluster`, "
            "or unset RAY_ADDRESS to run on this machine alone"
        ) from None
    if ray.is_initialized():
        return ray
    address = os.environ["RAY_ADDRESS"]
    # Workers find the program's own modules (`pipeline`) as this process does, from its folder.
    environment = {"env_vars": {"PYTHONPATH": os.getcwd()}}
    try:
        _knock(address)
        ray.init(logging_level=logging.ERROR, log_to_driver=False, runtime_env=environment)
    except (OSError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
        raise LfrError(f"no Ray cluster at RAY_ADDRESS={address}: {_one_line(error)}") from None
    return ray


def _knock(address: str) -> None:
    """Fail in seconds where nothing listens; Ray itself tries for two minutes."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if host and port.isdigit():
        socket.create_connection((host, int(port)), timeout=5).close()


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())
