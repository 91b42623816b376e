"""What an environment says, by what `external.arms` calls it: columns of a dataset, and success."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.errors import LfrError
from lfr.external import EnvironmentParams


def column_of(
    observed: Any, column: str, params: EnvironmentParams, name: str
) -> NDArray[np.float64]:
    """The numbers of a dataset's column in what an environment observes.

    Args:
        name: of the arm and task, for the message.

    Raises:
        LfrError: there is no such entry; the message lists those that there are.
    """
    entry = params.observation.get(column)
    if entry is None and not params.observation and not isinstance(observed, Mapping):
        return np.asarray(observed, np.float64).ravel()
    there, way = observed, entry.split(".") if entry is not None else []
    for key in way:
        if not isinstance(there, Mapping) or key not in there:
            break
        there = there[key]
    else:
        if way and not isinstance(there, Mapping):
            return np.asarray(there, np.float64).ravel()
    raise LfrError(
        f"{name}: {column} is {entry!r} of the environment's observation, which has "
        f"{', '.join(_entries(observed)) or 'no entries'}; say which under 'observation'"
    )


def succeeded(reward: float, info: Mapping[str, Any], params: EnvironmentParams, name: str) -> bool:
    """Whether the task has succeeded, by what a step gave.

    Raises:
        LfrError: the environment does not say.
    """
    if params.success_reward is not None:
        return reward >= params.success_reward
    if params.success not in info:
        raise LfrError(
            f"{name}: the environment never says {params.success!r}; its info has "
            f"{', '.join(info) or 'nothing'}; name one under 'success', or a 'success_reward'"
        )
    return bool(np.asarray(info[params.success]).item())


def _entries(observed: Any, before: str = "") -> list[str]:
    """The dotted names of all that an observation holds."""
    if not isinstance(observed, Mapping):
        return [before] if before else []
    found = []
    for key, value in observed.items():
        found += _entries(value, f"{before}.{key}" if before else str(key))
    return found
