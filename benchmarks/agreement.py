"""Whether the engine does what stock robosuite does where there is contact: by distribution.

    python -m benchmarks.agreement [--seeds 100] [--out results/benchmarks]

In contact, rounding grows until two builds of MuJoCo part, so motion cannot be compared step by
step. Here the scripted expert, without noise, acts from the same starts in the engine and in
robosuite's own loop: success, episode length and where the object ends must have the same
distribution. How many starts end alike one by one is written down beside it.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import fisher_exact, ks_2samp

from benchmarks._figures import FOLDER
from lfr.artifacts import provenance, write_json
from lfr.demos.expert import Expert, ExpertParams
from lfr.embodiments import embodiments
from lfr.sim.simulation import Simulation
from lfr.sim.stock import StockSimulation
from lfr.tasks import TASKS

LONGEST = 300  # control steps of an episode
ARMS = ("panda", "sawyer", "iiwa", "kinova3", "ur5e")
COMBINATIONS = [
    (body.name, task) for body in embodiments() if body.robot.name in ARMS for task in TASKS
]
AFTER_SUCCESS = 10  # so that a released object comes to rest


@dataclass(frozen=True)
class Agreement:
    """One combination of arm and task.

    Attributes:
        successes: of `seeds`, in the engine and in stock robosuite.
        alike: starts from which both succeed, or neither does.
        median_length: control steps until success, in each.
        object_apart: m between the two final object positions, from starts that end alike: median,
            and 90th percentile.
        p_success: Fisher's exact test that the success rates are one.
        p_length, p_object: two-sample Kolmogorov-Smirnov tests of the lengths and of the object's
            final x, y and z, in the base frame.
    """

    name: str
    seeds: int
    successes: tuple[int, int]
    alike: int
    median_length: tuple[float, float]
    object_apart: tuple[float, float]
    p_success: float
    p_length: float
    p_object: tuple[float, float, float]

    @property
    def smallest_p(self) -> float:
        return min(self.p_success, self.p_length, *self.p_object)


def compare(robot: str, task: str, seeds: int) -> Agreement:
    """Let the expert act from `seeds` starts in both."""
    ours = _episodes(Simulation(robot, task), seeds)
    theirs = _episodes(StockSimulation(robot, task), seeds)
    table = [[int(s.sum()), seeds - int(s.sum())] for s in (ours[:, 0], theirs[:, 0])]
    alike = ours[:, 0] == theirs[:, 0]
    apart = np.linalg.norm(ours[alike, 2:] - theirs[alike, 2:], axis=1)
    p_object = [float(ks_2samp(ours[:, k], theirs[:, k]).pvalue) for k in (2, 3, 4)]
    return Agreement(
        name=f"{robot}-{task}",
        seeds=seeds,
        successes=(table[0][0], table[1][0]),
        alike=int(alike.sum()),
        median_length=(float(np.median(ours[:, 1])), float(np.median(theirs[:, 1]))),
        object_apart=(float(np.median(apart)), float(np.quantile(apart, 0.9))),
        p_success=float(fisher_exact(table).pvalue),
        p_length=float(ks_2samp(ours[:, 1], theirs[:, 1]).pvalue),
        p_object=(p_object[0], p_object[1], p_object[2]),
    )


def _episodes(simulation: Simulation | StockSimulation, seeds: int) -> NDArray[np.float64]:
    """(seeds, 5): success, length, and the object's final position (3,)."""
    return np.array([_episode(simulation, seed) for seed in range(seeds)])


def _episode(simulation: Simulation | StockSimulation, seed: int) -> list[float]:
    observation = simulation.reset(seed)
    expert = Expert(simulation.task, simulation.layout, ExpertParams())
    controller = simulation.embodiment.controller
    succeeded, length = False, LONGEST
    for step in range(LONGEST):
        action = controller.label(expert.clean(observation), simulation.configuration())
        steps = simulation.step(action[None])
        observation = steps.observations[-1]
        if steps.successes[-1] and not succeeded:
            succeeded, length = True, step + 1
        if succeeded and step + 1 >= length + AFTER_SUCCESS:
            break
    place = observation[simulation.layout.slice(f"{simulation.task.manipulated}_pos")]
    return [float(succeeded), float(length), *(float(x) for x in place)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--out", type=Path, default=FOLDER)
    arguments = parser.parse_args()
    rows = []
    with ProcessPoolExecutor() as pool:
        pairs = [pool.submit(compare, *pair, arguments.seeds) for pair in COMBINATIONS]
        for found in (pair.result() for pair in pairs):
            rows.append(asdict(found) | {"smallest_p": found.smallest_p})
            print(
                f"{found.name:22s} success {found.successes[0]} and {found.successes[1]} of "
                f"{found.seeds} ({found.alike} alike), length {found.median_length[0]:g} and "
                f"{found.median_length[1]:g}, objects {1000 * found.object_apart[0]:.2g} mm apart, "
                f"smallest p {found.smallest_p:.2g}",
                flush=True,
            )
    path = arguments.out / "agreement.json"
    write_json(path, {"combinations": rows, "made_with": provenance()})
    print(path)


if __name__ == "__main__":
    main()
