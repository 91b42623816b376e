"""What stages do alike: names, a place for unfinished work, and what a run says of itself."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.artifacts import (
    code_fingerprint,
    fingerprint,
    provenance,
    work_folder,
    write_json,
    write_whole,
)
from lfr.embodiments import embodiment
from lfr.errors import ParameterError
from lfr.jobs import peak_memory
from lfr.params import read_yaml
from lfr.tasks import task as task_named

# When a stage imports this: a commit that is made while it runs is not what it runs.
BEGAN, MADE_BY = time.perf_counter(), provenance()


def dataset_name(robot: str, task: str) -> str:
    """What the demonstrations of a task by a robot are called, as logs and as a dataset.

    Raises:
        UnknownNameError: there is no such robot or task.
    """
    return f"{embodiment(robot).name}-{task_named(task).name}"


def rows_of(datasets: Iterable[Path]) -> list[Path]:
    """The parts of datasets that training reads: all but the videos."""
    return [path / part for path in datasets for part in ("meta", "data")]


def unfinished_work(stage: str, key: str, *parts: object) -> Path:
    """The folder of this stage's finished jobs and checkpoints, for these inputs and its code.

    It outlives the stage, since `dvc repro` may be killed before it has noted that the stage is
    done; what earlier inputs left under the same key is removed here.

    Args:
        parts: all that the work depends on beside the stage's code; a Path counts by its content.
    """
    folder = work_folder(f"{stage}/{key}", fingerprint(code_fingerprint(*code_of(stage)), *parts))
    for other in folder.parent.iterdir():
        if other != folder:
            shutil.rmtree(other)
    return folder


def code_of(stage: str) -> tuple[str, ...]:
    """The rooms of the library that a stage depends on, as dvc.yaml lists them."""
    deps = read_yaml(Path(__file__).parent.parent / "dvc.yaml")["stages"][stage]["deps"]
    rooms = (str(dep) for dep in deps if str(dep).startswith("lfr/"))
    return tuple(room.removesuffix(".py").replace("/", ".") for room in rooms)


def write_metrics(stage: str, key: str, metrics: dict[str, Any]) -> None:
    """Write results/<stage>/<key>.json: the metrics, and those of the run that made them.

    Of the run, `lfr.evaluation.records.StageRun` reads the wall-clock seconds, the peak memory of
    its largest process in bytes, and the git revision and versions (`lfr.artifacts.provenance`).
    """
    run = {
        "seconds": round(time.perf_counter() - BEGAN, 1),
        "peak_memory": peak_memory(),
        "provenance": MADE_BY,
    }
    write_json(Path("results") / stage / f"{key}.json", {**metrics, **run})


@dataclass(frozen=True)
class SeedParams:
    """Section ``seeds`` of params.yaml.

    Attributes:
        models: of the skill models and mappings, and of the split into training and held-out
            episodes.
        transfer: one run of transfer learning for each.
    """

    models: int = 0
    transfer: tuple[int, ...] = (0,)

    def __post_init__(self) -> None:
        if not self.transfer or len(set(self.transfer)) != len(self.transfer):
            raise ParameterError(f"transfer must name each seed once, found {self.transfer}")


def models_into(out: Path, models: Path) -> None:
    """Copy finished models out of the work folder, all of them or none."""
    with write_whole(out) as partial:
        shutil.copytree(models, partial)
