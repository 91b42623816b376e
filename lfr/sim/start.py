"""Where an episode starts: stock robosuite's reset distributions, drawn in stock's own order.

A generator in the same state gives the same start here as in stock robosuite, so a seed names one
start for the engine and for the oracle alike.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lfr.compiled import compiled
from lfr.sim.pcg64 import generator, normal, seed_generator, uniform


class StartArrays(NamedTuple):
    """All that is random at the start of an episode, for N objects; m and rad, world frame.

    Objects stand in the order in which stock draws them, those that it parks afterwards too, since
    they keep others out of their place.
    """

    joint_position: NDArray[np.float64]  # (N,) nominal
    joint_noise: float  # standard deviation of Gaussian noise on it
    open_fingers: NDArray[np.float64]  # (F,) qpos
    regions: NDArray[np.float64]  # (N, 2, 2) x and y, low and high
    heights: NDArray[np.float64]  # (N,) at which it is let go
    extents: NDArray[np.float64]  # (N, 3) horizontal radius, bottom and top from its origin
    check_overlap: NDArray[np.bool_]  # (N,) draw again while it overlaps one that is placed
    addresses: NDArray[np.int64]  # (N,) of its pose in qpos, -1 where the scene leaves it out
    sized: bool  # Lift's cube, whose half sizes are drawn
    sizes: NDArray[np.float64]  # (3, 2) low and high


class Drawn(NamedTuple):
    """One start, and the generator it comes from."""

    generator: NDArray[np.uint64]
    joint_position: NDArray[np.float64]  # (N,)
    poses: NDArray[np.float64]  # (N, 7) position and quaternion wxyz
    cube_size: NDArray[np.float64]  # (3,) half sizes, unchanged where nothing is drawn


def room(joints: int, objects: int) -> Drawn:
    """Room for a start of an arm with so many joints among so many objects."""
    return Drawn(generator(), np.zeros(joints), np.zeros((objects, 7)), np.zeros(3))


@compiled
def draw(start: StartArrays, seed: int, drawn: Drawn) -> None:
    """The start named by `seed`."""
    rng = drawn.generator
    seed_generator(seed, rng)
    raised = 0.0
    if start.sized:
        for i in range(3):
            drawn.cube_size[i] = _between(rng, start.sizes[i, 0], start.sizes[i, 1])
        raised = drawn.cube_size[2]  # the cube's size moves the height at which it is let go
    for j in range(start.joint_position.shape[0]):
        drawn.joint_position[j] = start.joint_position[j] + normal(rng) * start.joint_noise
    for i in range(start.heights.shape[0]):
        x, y = _free_place(start, i, drawn.poses, rng)
        angle = _between(rng, 0.0, 2.0 * math.pi)
        drawn.poses[i, 0], drawn.poses[i, 1] = x, y
        drawn.poses[i, 2] = start.heights[i] + raised
        drawn.poses[i, 3], drawn.poses[i, 6] = math.cos(angle / 2), math.sin(angle / 2)
        drawn.poses[i, 4] = drawn.poses[i, 5] = 0.0


@compiled
def _free_place(
    start: StartArrays, i: int, poses: NDArray[np.float64], rng: NDArray[np.uint64]
) -> tuple[float, float]:
    region = start.regions[i]
    while True:
        x = _between(rng, region[0, 0], region[0, 1])
        y = _between(rng, region[1, 0], region[1, 1])
        free = True
        if start.check_overlap[i]:
            for k in range(i):
                apart = math.hypot(x - poses[k, 0], y - poses[k, 1])
                above = start.heights[i] - start.heights[k]
                close = apart <= start.extents[k, 0] + start.extents[i, 0]
                if close and above <= start.extents[k, 2] - start.extents[i, 1]:
                    free = False
        if free:
            return x, y


@compiled
def _between(rng: NDArray[np.uint64], low: float, high: float) -> float:
    """As `Generator.uniform`."""
    return low + (high - low) * uniform(rng)
