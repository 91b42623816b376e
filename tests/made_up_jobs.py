"""Jobs for test_jobs.py, in a module that a worker loads quickly."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.errors import DataError, UnknownNameError
from lfr.jobs import report
from lfr.jobs.memory import own_peak


@dataclass(frozen=True)
class Spec:
    number: int
    folder: str = ""


def square(spec: Spec) -> dict[str, Any]:
    if spec.folder:
        with (Path(spec.folder) / "ran").open("a") as log:
            log.write(f"{spec.number}\n")
    return {"square": spec.number**2, "pair": (spec.number, 0.1)}


def numerical(seed: int) -> tuple[float, int]:
    import torch

    generator = torch.Generator().manual_seed(seed)
    matrix = torch.randn(400, 400, generator=generator)
    return (matrix @ matrix).square().sum().item(), torch.get_num_threads()


def faulting(times: int) -> int:
    """Page faults of writing four arrays of 16 MiB and freeing them, so many times."""
    import resource

    import numpy as np

    [np.ones(2**21) for _ in range(4)]
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(times):
        [np.ones(2**21) for _ in range(4)]
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before


def unknown(name: str) -> None:
    raise UnknownNameError("robot", name, ["panda"])


def damaged(name: str) -> None:
    raise DataError("cut off", file=name, episode=3)


def faulty(spec: int) -> float:
    return 1 / (spec - spec)


def dies_once(spec: Spec) -> int:
    mark = Path(spec.folder) / f"mark-{spec.number}"
    if spec.number % 2 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return spec.number


def writes(folder: str) -> int:
    time.sleep(0.5)
    (Path(folder) / "written").write_text("0")
    return 0


def reads(spec: Spec) -> int:
    """Its number, or -1 where `writes` has not written yet."""
    return spec.number if (Path(spec.folder) / "written").exists() else -1


def clears(folder: str) -> int:
    """Takes away what `reads` looks for."""
    (Path(folder) / "written").unlink()
    return 0


def dies(spec: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def hungry(megabytes: int) -> int:
    return own_peak() if b"\x01" * (megabytes * 2**20) else 0


def reporting(steps: int) -> int:
    for step in range(steps):
        report(step, steps)
        time.sleep(0.3)
    return steps
