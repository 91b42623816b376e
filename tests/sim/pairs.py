"""The engine and its oracle, built once for all tests of this folder."""

import functools

import numpy as np
from numpy.typing import NDArray

from lfr.robots import ROBOTS
from lfr.sim.simulation import Simulation, simulation
from lfr.sim.stock import StockSimulation
from lfr.tasks import TASKS

COMBINATIONS = [(robot, task) for robot in ROBOTS for task in TASKS]


@functools.cache
def stock(robot: str, task: str) -> StockSimulation:
    return StockSimulation(robot, task)


def pair(robot: str, task: str, seed: int) -> tuple[Simulation, StockSimulation]:
    """Both at the start named by `seed`."""
    both = simulation(robot, task), stock(robot, task)
    for one in both:
        one.reset(seed)
    return both


def put(one: Simulation | StockSimulation, pose: NDArray[np.float64], which: int = 0) -> None:
    """Move an observed object (the `which`-th) to `pose` (7,) and let it rest there."""
    body = list(one.task.objects.values())[which]
    joint = one._data.joint(one._model.body(body).jntadr[0])
    joint.qpos[:], joint.qvel[:] = pose, 0.0


def reach(one: Simulation | StockSimulation) -> NDArray[np.float64]:
    """An action (7,) that moves the open hand's grip site onto the first object's grasp point."""
    observation, layout = one.observation(), one.layout
    name = next(iter(one.task.objects))
    group = "handle_to_eef" if one.task.name == "nut_assembly" else f"{name}_to_eef"
    offset = observation[layout.slice(group)]
    # hover first, so that the fingers come down around the object and not onto it
    height = 0.06 if np.linalg.norm(offset[:2]) > 0.01 else 0.0
    action = np.zeros(7)
    action[:3] = np.clip((offset + np.array([0.0, 0.0, height])) / 0.05, -1, 1)
    action[6] = -1.0
    return action
