"""Datasets of arms that are not this project's, checked and read by their mapping of columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lfr.data.checks import check_dataset
from lfr.data.episode import Feature
from lfr.data.selection import Selection, select
from lfr.data.tables import DatasetFiles
from lfr.data.windows import DemonstrationSet, read_dataset
from lfr.errors import DataError
from lfr.external import ExternalArm

TOLERANCE = 1e-3  # of an action beyond [-1, 1]: bounds that were copied with four digits


def read_external(arm: ExternalArm, task: str) -> DemonstrationSet:
    """An arm's demonstrations of one task.

    Raises:
        DataError: the dataset is missing or not what the mapping says: a column or dimension is
            missing, another fps or robot, no episode of the task, a value that is not finite, or
            an action beyond its bounds. It names file, episode and column, found and expected.
    """
    path, columns = arm.dataset(task), arm.columns(task)
    selected(arm, task)  # a column that is missing is told before its values are looked at
    features = DatasetFiles.open(path).features
    needed = {key: Feature(key, features[key]["dtype"], None, "") for key in columns.needed}
    check_dataset(path, features=needed, fps=arm.fps, robot=arm.robot_type)
    found = read_dataset(path, columns, arm.instruction(task))
    _check_bounds(path / "data", columns.action.column, found)
    return found


def selected(arm: ExternalArm, task: str) -> Selection:
    """What a task's dataset gives as observation and action, by its metadata alone.

    Raises:
        DataError: there is no dataset, or it lacks a column or dimension.
    """
    return select(DatasetFiles.open(arm.dataset(task)), arm.columns(task))


def _check_bounds(file: Path, column: str, found: DemonstrationSet) -> None:
    """Actions beyond their bounds could never be said by a decoder, which ends at them."""
    space, actions = found.action_space, found.actions.numpy()
    low, high = actions.min(0), actions.max(0)
    beyond = (low < -1 - TOLERANCE) | (high > 1 + TOLERANCE)
    if not beyond.any():
        return
    least, most = space.physical(low), space.physical(high)
    place = int(np.argmax(beyond))
    raise DataError(
        "actions beyond low and high; `lfr columns` prints bounds for all of them",
        file=file,
        column=f"{column}, dimension {space.names[place]}",
        found=f"{least[place]:.4g} to {most[place]:.4g}",
        expected=f"{space.low[place]:.4g} to {space.high[place]:.4g}",
    )
