"""Whether a dataset is what training needs, told cheaply and with the place of what is wrong."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lfr.data import tables
from lfr.data.episode import FEATURES, Feature
from lfr.data.tables import DatasetFiles
from lfr.errors import DataError

EPISODE_INDEX, FRAME_INDEX = "episode_index", "frame_index"


def check_dataset(
    path: Path,
    *,
    features: Mapping[str, Feature] | None = None,
    fps: float | None = None,
    robot: str | None = None,
    task: str | None = None,
) -> None:
    """Check a dataset for all that would spoil training on it, without importing LeRobot.

    Args:
        path: the dataset's folder.
        features: what must be there; by default FEATURES, with the shapes that they fix.
        fps, robot, task: what they must be; None takes any.

    Raises:
        DataError: a column is missing or has another type, shape or names; another fps, robot or
            task; a value that is not finite; no successful episode; a cut-off file; rows that do
            not add up. It names file, episode and column, what was found and what was expected.
    """
    files = DatasetFiles.open(Path(path))
    info = files.path / "meta" / "info.json"
    _require("another fps", info, files.info.get("fps"), fps)
    _require("another robot or controller", info, files.info.get("robot_type"), robot)
    needed = features if features is not None else {f.key: f for f in FEATURES}
    for key, feature in needed.items():
        _check_schema(files, info, key, feature)
    _check_episodes(files, task)
    _check_rows(files, needed)


def _require(message: str, file: Path, found: object, expected: object) -> None:
    if expected is not None and found != expected:
        raise DataError(message, file=file, found=found, expected=expected)


def _check_schema(files: DatasetFiles, info: Path, key: str, feature: Feature) -> None:
    if key not in files.features:
        found = ", ".join(files.features)
        raise DataError("a column is missing", file=info, column=key, found=found, expected=key)
    given = files.features[key]
    expected: dict[str, object] = {"dtype": feature.dtype}
    if feature.names:
        expected |= {"shape": list(feature.shape), "names": list(feature.names)}
    for what, value in expected.items():
        found = given.get(what)
        if (list(found) if isinstance(found, tuple) else found) != value:
            raise DataError(f"another {what}", file=info, column=key, found=found, expected=value)


def _check_episodes(files: DatasetFiles, task: str | None) -> None:
    folder = files.path / "meta" / "episodes"
    lengths = files.episodes["length"].to_pylist()
    _require("another number of episodes", folder, len(lengths), files.info.get("total_episodes"))
    _require("another number of rows", folder, sum(lengths), files.info.get("total_frames"))
    indices = files.episodes[EPISODE_INDEX].to_pylist()
    _require("episodes out of order", folder, indices, list(range(len(lengths))))
    if task is not None:
        found = files.task_names()
        _require("another task", folder, ", ".join(found) or "no column task_name", task)
    if "success" in files.episodes.column_names:
        # a gap says nothing: of datasets that are merged, one may not have the column
        known = [one for one in files.episodes["success"].to_pylist() if isinstance(one, bool)]
        if known and not any(known):
            raise DataError(
                "no successful episode; record again",
                file=folder,
                column="success",
                found=f"0 of {len(known)}",
                expected="at least 1",
            )


def _check_rows(files: DatasetFiles, needed: Mapping[str, Feature]) -> None:
    table = files.data([*needed, EPISODE_INDEX, FRAME_INDEX])
    file = files.files("data")[0]
    lengths = files.episodes["length"].to_numpy()
    episode_index = _values(table, EPISODE_INDEX, file)
    if len(episode_index) != lengths.sum():
        raise DataError(
            "another number of rows than the episodes have",
            file=file,
            found=len(episode_index),
            expected=int(lengths.sum()),
        )
    expected = np.repeat(np.arange(len(lengths)), lengths)
    _compare(file, EPISODE_INDEX, episode_index, expected, expected)
    starts = np.repeat(np.cumsum(lengths) - lengths, lengths)
    frames = np.arange(len(expected)) - starts
    _compare(file, FRAME_INDEX, _values(table, FRAME_INDEX, file), frames, expected)
    for key in needed:
        column = _values(table, key, file)
        shape = tuple(files.features[key]["shape"])
        found = column.shape[1:] or (1,)
        if found != shape:
            raise DataError("another shape", file=file, column=key, found=found, expected=shape)
        bad = ~np.isfinite(column).reshape(len(column), -1).all(axis=1)
        if bad.any():
            row = int(bad.argmax())
            raise DataError(
                "a value that is not finite",
                file=file,
                episode=int(episode_index[row]),
                column=key,
                found=f"{column[row].tolist()} in frame {frames[row]}",
                expected="finite numbers",
            )


def _compare(file: Path, column: str, found: NDArray, expected: NDArray, episodes: NDArray) -> None:
    wrong = found != expected
    if wrong.any():
        row = int(wrong.argmax())
        raise DataError(
            f"row {row} is out of order",
            file=file,
            episode=int(episodes[row]),
            column=column,
            found=found[row],
            expected=expected[row],
        )


def _values(table: object, column: str, file: Path) -> NDArray:
    try:
        return tables.values(table, column)  # pyright: ignore[reportArgumentType]
    except (TypeError, ValueError) as error:
        raise DataError(
            "another shape", file=file, column=column, found=error, expected="one shape, no gaps"
        ) from error
