"""Datasets of arms that are not this project's, checked and read by their mapping of columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lfr.data.checks import check_dataset
from lfr.data.episode import Feature
from lfr.data.resample import resampled
from lfr.data.selection import Chosen, Selection, select, unreadable
from lfr.data.tables import DatasetFiles
from lfr.data.windows import DemonstrationSet, read_dataset
from lfr.errors import DataError
from lfr.external import ExternalArm
from lfr.spaces import KNOWN, quantity, space

TOLERANCE = 1e-3  # of an action beyond [-1, 1]: bounds that were copied with four digits


def read_external(arm: ExternalArm, task: str) -> DemonstrationSet:
    """An arm's demonstrations of one task, at the rate at which models see them.

    Raises:
        DataError: the dataset is missing or not what the mapping says: a column or dimension is
            missing, or has a name that does not say what it is, another fps or robot, no episode of
            the task, a value that is not finite, or an action beyond its bounds. It names file,
            episode and column, found and expected.
    """
    path, columns = arm.dataset(task), arm.columns(task)
    selected(arm, task)  # a column that is missing is told before its values are looked at
    features = DatasetFiles.open(path).features
    needed = {key: Feature(key, features[key]["dtype"], None, "") for key in columns.needed}
    check_dataset(path, features=needed, fps=arm.fps, robot=arm.robot_type)
    found = read_dataset(path, columns, arm.instruction(task))
    _check_bounds(path / "data", columns.action.column, found)
    if arm.resample is None:
        return found
    try:
        return resampled(found, arm.resample, columns.action.deltas or ())
    except ValueError as error:
        raise DataError(str(error), file=path, column=columns.action.column) from None


def selected(arm: ExternalArm, task: str) -> Selection:
    """What a task's dataset gives as observation and action, by its metadata alone.

    Raises:
        DataError: there is no dataset, it lacks a column or dimension, or the name of one does not
            say what it is.
    """
    files = DatasetFiles.open(arm.dataset(task))
    found = select(files, arm.columns(task))
    file = files.path / "meta" / "info.json"
    for part in found.observation:
        _check_names(file, part)
    if arm.cartesian:
        _check_names(file, found.action)
        for part in (*found.observation, found.action):
            _check_moves(file, part)
    return found


def _check_names(file: Path, part: Chosen) -> None:
    """A prior could not scale what it does not know; that would be told only as it is trained."""
    for name in unreadable(part.names):
        raise DataError(
            "a name that does not say what it is; `number.<name>` and `joint.<name>` say no more "
            "than that",
            file=file, column=part.column, found=name, expected=f"one of {', '.join(KNOWN)}",
        )  # fmt: skip


def _check_moves(file: Path, part: Chosen) -> None:
    for found in space(part.names).quantities:
        whole = quantity(found.name)
        if found.moves in ("unknown", "with the base") or found.size != whole.size:
            raise DataError(
                "how it moves with the scene is not known; leave out `cartesian: true`",
                file=file, column=part.column, found=found.names[0],
            )  # fmt: skip


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
