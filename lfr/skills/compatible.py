"""Whether two arms can be mapped onto each other: G and F compare them in the same states."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import zip_longest

from lfr.data.episode import FPS
from lfr.data.external import selected
from lfr.errors import DataError
from lfr.external import ExternalArm
from lfr.scenarios import Scenario, transfers_of
from lfr.tasks import TASKS


def check_arms(scenario: Scenario, arms: Mapping[str, ExternalArm]) -> None:
    """Hold both arms of a scenario to the same observation of each task, by metadata alone.

    The source's prior of a task is asked about states of the target's, and the other way round;
    so every dimension must mean the same to both. Nothing is asked of the actions.

    Args:
        arms: the external ones, by name.

    Raises:
        DataError: an observation differs, or the rate of the control steps; or a dataset lacks a
            column that the mapping names.
    """
    if not arms:
        return
    first, second = scenario.robots
    rates = [arms[robot].fps if robot in arms else FPS for robot in (first, second)]
    if rates[0] != rates[1]:
        raise DataError(
            f"{second} has another fps than {first}, so their skills would last differently; "
            "resample one of them",
            file="params.yaml", column="external.arms", found=rates[1], expected=rates[0],
        )  # fmt: skip
    for task in scenario.common:
        _compare(task, first, second, *(_names(robot, task, arms) for robot in (first, second)))
    for transfer in transfers_of(scenario):  # the new task's columns, before anything is trained
        _names(transfer.source, transfer.task, arms)


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
