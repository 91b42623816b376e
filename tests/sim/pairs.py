"""The engine and its oracle, built once for all tests of this folder."""

import functools
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from lfr.embodiments import embodiment, embodiments
from lfr.sim.simulation import Simulation, simulation
from lfr.sim.stock import StockSimulation
from lfr.tasks import TASKS

EMBODIMENTS = [body.name for body in embodiments()]
QUICK = {
    *(("panda", task) for task in TASKS),
    *(("ur5e-joint_position", task) for task in TASKS),
    *((name, list(TASKS)[number % len(TASKS)]) for number, name in enumerate(EMBODIMENTS)),
}
"""Every embodiment in a task and every task under both controllers; the others are slow tests."""

COMBINATIONS: list[Any] = [
    pytest.param(name, task, marks=() if (name, task) in QUICK else pytest.mark.slow)
    for name in EMBODIMENTS
    for task in TASKS
]


@functools.lru_cache(maxsize=4)
def stock(name: str, task: str) -> StockSimulation:
    return StockSimulation(name, task)


def pair(name: str, task: str, seed: int) -> tuple[Simulation, StockSimulation]:
    """Both at the start named by `seed`."""
    both = simulation(name, task), stock(name, task)
    for one in both:
        one.reset(seed)
    return both


def put(one: Simulation | StockSimulation, pose: NDArray[np.float64], which: int = 0) -> None:
    """Move an observed object (the `which`-th) to `pose` (7,) and let it rest there."""
    body = list(one.task.objects.values())[which]
    joint = one._data.joint(one._model.body(body).jntadr[0])
    joint.qpos[:], joint.qvel[:] = pose, 0.0


def still(name: str, steps: int = 1, gripper: float = 0.0) -> NDArray[np.float64]:
    """Actions (steps, A) that ask for no motion."""
    actions = np.zeros((steps, embodiment(name).action.size))
    actions[:, -1] = gripper
    return actions


def reach(one: Simulation) -> NDArray[np.float64]:
    """An action (A,) that moves the open hand's grip site onto the first object's grasp point."""
    observation, layout = one.observation(), one.layout
    goal = "handle" if one.task.name == "nut_assembly" else one.task.manipulated
    offset = observation[layout.slice(f"eef_to_{goal}")]
    # hover first, so that the fingers come down around the object and not onto it
    height = 0.06 if np.linalg.norm(offset[:2]) > 0.01 else 0.0
    motion = np.zeros(6)
    motion[:3] = np.clip((offset + np.array([0.0, 0.0, height])) / 0.05, -1, 1)
    return np.append(one.embodiment.controller.action_of(motion, one.configuration()), -1.0)
