"""A learning run on disk, so that it goes on exactly where it was killed."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from torch import Tensor

from lfr.artifacts import load_model, save_model
from lfr.errors import DataError

PREFIX = "checkpoint-"


def save_checkpoint(
    work: Path, env_steps: int, content: dict[str, Any], tensors: dict[str, Tensor]
) -> None:
    """Write ``work/checkpoint-<env_steps>`` whole, then remove the older ones.

    Each has its own name, so at every moment one whole checkpoint stands under its own.
    """
    folder = work / f"{PREFIX}{env_steps:09d}"
    save_model(folder, content, tensors)
    for older in work.glob(f"{PREFIX}*"):
        if older.name < folder.name:
            shutil.rmtree(older)


def load_checkpoint(
    work: Path, identity: dict[str, Any]
) -> tuple[dict[str, Any], dict[str, Tensor]] | None:
    """The latest checkpoint in ``work``, or None if there is none.

    Raises:
        DataError: it is damaged, or of another run (other parameters or another seed).
    """
    folders = sorted(work.glob(f"{PREFIX}*"))
    if not folders:
        return None
    content, tensors = load_model(folders[-1])
    if content["identity"] != identity:
        different = [k for k in identity if content["identity"].get(k) != identity[k]]
        raise DataError(
            "a checkpoint of another run; remove it or choose another work folder",
            file=folders[-1],
            column=different[0] if different else None,
        )
    return content, tensors
