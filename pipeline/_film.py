"""Attempts at one task as rows of pictures, and how high each brought its object."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lfr.artifacts import write_whole
from lfr.errors import MissingLibraryError
from lfr.evaluation.figures import COLORS, STYLE
from lfr.evaluation.trials import Trial
from lfr.policies import Array, Outcome, run_episode
from lfr.seeds import episode_seed
from lfr.sim.camera import Camera
from lfr.sim.simulation import Simulation, simulation
from lfr.sim.steps import Steps
from lfr.tasks import task as task_named

SIZE = 200  # pixels of a picture
SECONDS = (0.0, 1.0, 2.0, 3.0, 4.0)  # at which one is taken
RATE = 20  # control steps a second
LINGER = 20  # control steps shown after success


class Filmed:
    """A simulation that is looked at while a policy acts in it.

    Attributes:
        heights: of the task's object, m, at every control step.
        pictures: at `SECONDS`, (SIZE, SIZE, 3) uint8; of a shorter episode the last one again, and
            none without OpenGL.
    """

    def __init__(self, simulated: Simulation) -> None:
        self.simulation, self.horizon = simulated, int(SECONDS[-1] * RATE) + LINGER
        name = f"{simulated.task.manipulated}_pos"
        self._height = simulated.layout.slice(name).start + 2
        self._camera = _camera(simulated)

    def reset(self, seed: int) -> Array:
        observation = self.simulation.reset(seed)
        self.heights: list[float] = []
        self.pictures: list[NDArray[np.uint8]] = []
        self._look(observation)
        return observation

    def step(self, actions: Array, stop_on_success: bool = False) -> Steps:
        steps = [self._one(action) for action in actions]
        return Steps(
            np.concatenate([step.observations for step in steps]),
            np.concatenate([step.rewards for step in steps]),
            np.concatenate([step.successes for step in steps]),
            steps[-1].diverged,
        )

    def _one(self, action: Array) -> Steps:
        step = self.simulation.step(action[None])
        self._look(step.observations[-1])
        return step

    def _look(self, observation: Array) -> None:
        if self._camera and len(self.heights) in [round(t * RATE) for t in SECONDS]:
            self.pictures.append(self._camera.render(self.simulation))
        self.heights.append(float(observation[self._height]))


def film(trials: Mapping[str, Trial], index: int, path: Path) -> dict[str, Outcome]:
    """Draw the held-out start ``index`` of every trial as a row of ``path``; how each ended.

    Args:
        trials: of one task, by what stands beside their row.
        path: a PNG file.
    """
    import matplotlib as mpl
    from matplotlib import pyplot as plt

    shown, outcomes = {}, {}
    for name, trial in trials.items():
        filmed = Filmed(simulation(trial.robot, trial.task))
        policy = trial.policy.load(trial.robot)
        seed = episode_seed("held-out", index)
        outcomes[name] = run_episode(policy, filmed, seed, linger=LINGER)
        shown[name] = filmed
    pictures = all(filmed.pictures for filmed in shown.values())
    rows, columns = len(shown) * pictures, len(SECONDS)
    style = {key: value for key, value in STYLE.items() if not key.startswith("svg")}
    with mpl.rc_context(style):
        figure = plt.figure(figsize=(10, 2.0 * rows + 2.6), layout="constrained")
        grid = figure.add_gridspec(rows + 1, columns, height_ratios=[2.0] * rows + [2.2])
        for row, (name, filmed) in enumerate(shown.items()):
            taken = filmed.pictures + filmed.pictures[-1:] * (columns - len(filmed.pictures))
            for column, picture in enumerate(taken[:columns] if pictures else ()):
                axes = figure.add_subplot(grid[row, column])
                axes.imshow(picture)
                axes.set(xticks=[], yticks=[])
                if row == 0:
                    axes.set_title(f"{SECONDS[column]:.0f} s")
                if column == 0:
                    axes.set_ylabel(name)
        axes = figure.add_subplot(grid[rows, :])
        for color, (name, filmed) in zip(COLORS, shown.items(), strict=False):
            height = 100.0 * (np.array(filmed.heights) - min(filmed.heights))
            axes.plot(
                np.arange(len(height)) / RATE, height, color=color, label=name.replace("\n", " ")
            )
        thing = task_named(next(iter(trials.values())).task).manipulated
        axes.set(xlabel="s", ylabel=f"cm that the {thing} was raised")
        axes.legend(frameon=False, loc="upper left")
        with write_whole(path) as partial:
            figure.savefig(partial, format="png", dpi=110)
        plt.close(figure)
    return outcomes


def _camera(simulated: Simulation) -> Camera | None:
    try:
        return Camera(simulated.embodiment.name, simulated.task.name, "frontview", SIZE, SIZE)
    except MissingLibraryError:
        return None
