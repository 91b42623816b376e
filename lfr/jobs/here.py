"""Jobs one after the other in this process."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from functools import partial

from lfr.artifacts import as_json
from lfr.jobs.memory import keep_freed_memory
from lfr.jobs.order import Order
from lfr.jobs.results import Results, listening

# Read by a numerical library when it is loaded.
ONE_THREAD = {
    name: "1"
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
}


def run_here(order: Order, results: Results) -> None:
    """Run the jobs here; what they raise comes through as it is."""
    keep_freed_memory()
    with one_thread():
        while (job := order.next()) is not None:
            with listening(partial(results.report, job)):
                result = as_json(job.function(job.spec))
            results.finish(job, result)
            order.finish(job)


@contextlib.contextmanager
def one_thread() -> Iterator[None]:
    """One thread for numerical libraries: sums in one order, so the same bits as in a worker."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    torch = sys.modules.get("torch")  # loaded already, so it has read the environment
    threads = torch.get_num_threads() if torch else 0
    if torch:
        torch.set_num_threads(1)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        if torch:
            torch.set_num_threads(threads)
