"""What every stage does alike: its place for unfinished work, and its metrics with wall-clock."""

from __future__ import annotations

import shutil
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.artifacts import code_fingerprint, fingerprint, work_folder, write_json, write_whole
from lfr.errors import ParameterError

BEGAN = time.perf_counter()  # a stage imports this first


def unfinished_work(stage: str, key: str, *parts: object, code: tuple[str, ...]) -> Path:
    """The folder of this stage's finished jobs and checkpoints, for these inputs and this code.

    It outlives the stage, since `dvc repro` may be killed before it has noted that the stage is
    done; what earlier inputs left under the same key is removed here.

    Args:
        parts: all that the work depends on; a Path counts by its content.
        code: packages whose sources the work depends on.
    """
    folder = work_folder(f"{stage}/{key}", fingerprint(code_fingerprint(*code), *parts))
    for other in folder.parent.iterdir():
        if other != folder:
            shutil.rmtree(other)
    return folder


def write_metrics(path: Path, metrics: dict[str, Any]) -> None:
    """The stage's metrics, with the seconds that this run of it took."""
    seconds = round(time.perf_counter() - BEGAN, 1)
    write_json(path, {**metrics, "seconds": seconds})


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
