"""The tasks that the project knows, one file each; a new one is a file and an entry here."""

from __future__ import annotations

import math

from lfr.compiled import compiled, select
from lfr.compiled.arrays import Physics, SceneArrays
from lfr.errors import UnknownNameError
from lfr.tasks.lift import LIFT
from lfr.tasks.nut_assembly import NUT_ASSEMBLY
from lfr.tasks.pick_place import PICK_PLACE
from lfr.tasks.stack import STACK
from lfr.tasks.task import Task

__all__ = ["TASKS", "Task", "reward_and_success", "task"]

TASKS: dict[str, Task] = {one.name: one for one in (LIFT, STACK, PICK_PLACE, NUT_ASSEMBLY)}


def task(name: str) -> Task:
    """The task called `name`.

    Raises:
        UnknownNameError: there is none; the message lists those there are.
    """
    if name not in TASKS:
        raise UnknownNameError("task", name, tuple(TASKS))
    return TASKS[name]


@compiled
def _number(scene: SceneArrays) -> int:
    return scene.task


@compiled
def _unknown(physics: Physics, scene: SceneArrays) -> tuple[float, bool]:
    return math.nan, False


reward_and_success = select([one.reward for one in TASKS.values()], _number, _unknown)
"""Dense reward and success of the state that the last substep started from; NaN for no task."""
