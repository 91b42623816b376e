"""One training run on the engine: simulations, loop, and the final policy with its curve."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from lfr.artifacts import as_json
from lfr.errors import DataError
from lfr.spaces import Space
from lfr.transfer.environment import Resumable
from lfr.transfer.loop import TransferLoop
from lfr.transfer.methods.initialization import Initialization
from lfr.transfer.model import save_policy
from lfr.transfer.observer import Observer
from lfr.transfer.transfer_params import TransferParams


class TaskSimulation(Resumable, Protocol):
    """A simulation whose observation has names."""

    layout: Space


class Reported(Observer):
    """Forwards to another observer and moves the job's progress bar."""

    def __init__(self, observer: Observer) -> None:
        self.observer = observer
        self.on_episode = observer.on_episode
        self.on_update = observer.on_update
        self.on_evaluation = observer.on_evaluation

    def on_progress(self, env_steps: int, total: int) -> None:
        from lfr.jobs import report

        report(env_steps, total)
        self.observer.on_progress(env_steps, total)


def train(
    initialization: Initialization,
    robot: str,
    task: str,
    params: TransferParams,
    seed: int,
    *,
    out: Path,
    work: Path | None = None,
    about: dict[str, Any] | None = None,
    observer: Observer | None = None,
    simulate: Callable[[], TaskSimulation] | None = None,
) -> dict[str, Any]:
    """Learn ``task`` on ``robot`` and leave the policy in ``out``; meant to run inside a job.

    Args:
        initialization: from a method (`lfr.transfer.methods`).
        seed: of the run, 0 to 24 (each has its own share of the learning seeds).
        out: the final policy's folder, written whole at the end.
        work: checkpoints; a run that was killed goes on from the last one.
        about: what else is stored with the policy: transfer, method, revisions.
        simulate: makes one of the simulations that it learns in, where it is not the robot's own.

    Returns:
        JSON-able: seed, env_steps, updates, episodes, seconds (of learning, also in processes that
        were killed, up to their last checkpoint) and the curve, a list of `CurvePoint` as mappings,
        its first point before any RL.

    Raises:
        UnknownNameError: unknown robot or task.
        DataError: the source's prior was trained on another state layout.
    """
    make = simulate or partial(_own_simulation, robot, task)
    simulations = [make() for _ in range(params.simulations)]
    names = simulations[0].layout.names
    known = initialization.layout_names
    if names != known:
        pairs = zip(known, names, strict=False)
        found, expected = next((p for p in pairs if p[0] != p[1]), (known, names))
        raise DataError(
            f"the prior was trained on another state layout than {task}'s",
            file=out,
            found=found,
            expected=expected,
        )
    reported = Reported(observer or Observer())
    loop = TransferLoop(initialization, simulations, params, seed, work, reported)
    curve = [dataclasses.asdict(point) for point in loop.run()]
    described = {"robot": robot, "task": task, "seed": seed, "params": as_json(params)}
    save_policy(out, loop.actor, described | (about or {}))
    return {
        "seed": seed,
        "env_steps": loop.progress.env_steps,
        "updates": loop.progress.updates,
        "episodes": loop.progress.episodes,
        "seconds": loop.seconds,
        "curve": curve,
    }


def _own_simulation(robot: str, task: str) -> TaskSimulation:
    from lfr.sim.simulation import Simulation

    return Simulation(robot, task)
