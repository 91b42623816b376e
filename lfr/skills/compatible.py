"""Whether two arms can be mapped onto each other: G and F compare them in the same states."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import zip_longest
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.artifacts import read_json
from lfr.data.episode import FPS
from lfr.data.external import selected
from lfr.errors import DataError
from lfr.external import ExternalArm
from lfr.scenarios import Scenario, transfers_of
from lfr.spaces import space
from lfr.tasks import TASKS

Array = NDArray[np.float64]
APART = 30.0  # times as wide: a radian is 57 degrees, a metre 1000 millimetres


def check_arms(scenario: Scenario, arms: Mapping[str, ExternalArm]) -> None:
    """Hold both arms of a scenario to the same observation of each task, by metadata alone.

    The source's prior of a task is asked about states of the target's, and the other way round;
    so every dimension must mean the same to both. Nothing is asked of the actions.

    Args:
        arms: the external ones, by name.

    Raises:
        DataError: an observation differs, or its range so much that it is in another unit, or the
            rate of the control steps; or a dataset lacks a column that the mapping names.
    """
    if not arms:
        return
    first, second = scenario.robots
    rates = [arms[robot].rate if robot in arms else FPS for robot in (first, second)]
    if rates[0] != rates[1]:
        raise DataError(
            f"{second} has another fps than {first}, so their skills would last differently; "
            "`resample` the faster one",
            file="params.yaml", column="external.arms", found=rates[1], expected=rates[0],
        )  # fmt: skip
    for task in scenario.common:
        _compare(task, first, second, *(_names(robot, task, arms) for robot in (first, second)))
        if first in arms and second in arms:
            _compare_ranges(task, first, second, arms)
    for transfer in transfers_of(scenario):  # the new task's columns, before anything is trained
        _names(transfer.source, transfer.task, arms)


def _compare_ranges(task: str, first: str, second: str, arms: Mapping[str, ExternalArm]) -> None:
    expected, found = (_ranges(arms[robot], task) for robot in (first, second))
    if expected is None or found is None:
        return
    names = _names(first, task, arms)
    for name, quantity, wanted, given in zip(
        names, space(names).each(), expected, found, strict=True
    ):
        widths = sorted(float(high - low) for low, high in (wanted, given))
        if widths[0] > quantity.std_floor and widths[1] > APART * widths[0]:
            raise DataError(
                f"{second} and {first} observe {name} in different units, or scenes that have "
                f"nothing in common; give its column the right 'unit'",
                file="params.yaml", column=f"external.arms, observation, {name} of {task}",
                found=_shown(given), expected=f"about {_shown(wanted)}",
            )  # fmt: skip


def _ranges(arm: ExternalArm, task: str) -> NDArray[np.float64] | None:
    """Least and most (D, 2) of each dimension observed, by the dataset's own statistics."""
    file = arm.dataset(task) / "meta" / "stats.json"
    if not file.is_file():
        return None
    stats, found = read_json(file), []
    for part in selected(arm, task).observation:
        if not all({"min", "max"} <= set(stats.get(column, {})) for column in part.columns):
            return None
        low, high = _ends(stats, part.column, part.places)
        if part.minus is not None:
            least, most = _ends(stats, *part.minus)
            low, high = low - most, high - least
        found.append(np.stack(part.conversion.bounds(low, high, part.names), axis=1))
    return np.concatenate(found)


def _ends(stats: Mapping[str, Any], column: str, places: tuple[int, ...]) -> list[Array]:
    return [np.array(stats[column][end], np.float64)[list(places)] for end in ("min", "max")]


def _shown(bounds: NDArray[np.float64]) -> str:
    return f"{bounds[0]:.4g} to {bounds[1]:.4g}"


def _names(robot: str, task: str, arms: Mapping[str, ExternalArm]) -> tuple[str, ...]:
    if robot in arms:
        return selected(arms[robot], task).observation_names
    return TASKS[task].observation.names


def _compare(
    task: str, first: str, second: str, expected: tuple[str, ...], found: tuple[str, ...]
) -> None:
    for place, (wanted, given) in enumerate(zip_longest(expected, found)):
        if wanted != given:
            raise DataError(
                f"{second} observes {task} otherwise than {first}; choose the same quantities of "
                "both and call them alike under 'names'",
                file="params.yaml", column=f"external.arms, observation, dimension {place}",
                found=given, expected=wanted,
            )  # fmt: skip
