"""What stages do alike: names, a place for unfinished work, and what a run says of itself."""

from __future__ import annotations

import os
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
from lfr.errors import DataError, ParameterError
from lfr.jobs import peak_memory
from lfr.params import read_yaml
from lfr.tasks import task as task_named

DATASETS = (Path("data/lerobot"), Path("data/external"))  # that stages depend on
# When a stage imports this: a commit that is made while it runs is not what it runs.
BEGAN, MADE_BY = time.perf_counter(), provenance()


def dataset_name(robot: str, task: str) -> str:
    """What the demonstrations of a task by a robot are called, as logs and as a dataset.

    Raises:
        UnknownNameError: there is no such robot or task.
    """
    return f"{embodiment(robot).name}-{task_named(task).name}"


def rows_of(datasets: Iterable[Path]) -> list[Path]:
    """The parts of datasets that training reads: all but the videos.

    Raises:
        DataError: `dvc repro` has started this, and would not see that one has changed.
    """
    parts = [path / part for path in datasets for part in ("meta", "data")]
    if "DVC_STAGE" in os.environ:
        for part in parts:
            _refuse_unseen(part)
    return parts


def _refuse_unseen(path: Path) -> None:
    """DVC 3.67 follows a link that a stage depends on, and none to a folder below that."""
    place = Path(os.path.abspath(path))
    root = next((one for one in DATASETS if place.is_relative_to(one.absolute())), None)
    message = "DVC does not see when this dataset changes"
    if root is None:
        raise DataError(f"{message}; put it into data/external", file=path)
    above = [one for one in (place, *place.parents) if one.is_relative_to(root.absolute())]
    for folder in (*above[:-1], *place.rglob("*")):
        if folder.is_symlink() and folder.is_dir():
            raise DataError(
                f"{message}, as it follows no link to a folder below {root}; put the dataset there "
                f"itself, or make {root} the link", file=folder,
                found=f"a link to {folder.resolve()}",
            )  # fmt: skip


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
