"""The compiled engine against stock robosuite and against bare `mj_step`.

    python -m benchmarks.simulation [--repeats 9] [--out results/benchmarks]

Both sides carry out the same actions from the same start, the scripted expert's until it succeeds,
so that free motion, contact and grasp are in the mean as they are in the project's own runs. The
sides alternate; a ratio is the median of the repeats' ratios. Figures of one core count the
process's own time, which what else the machine does falsifies least; two cores against one count
the wall clock, so they need a quiet machine.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import mujoco
import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from benchmarks._figures import FOLDER, Figure, compare, show, write
from lfr.controllers import set_goal, set_torques
from lfr.controllers.controller import SUBSTEPS
from lfr.demos.expert import Expert, ExpertParams
from lfr.embodiments import embodiments
from lfr.evaluation.marked import put
from lfr.sim import kernel, libmujoco
from lfr.sim.batch import Batch
from lfr.sim.simulation import Simulation
from lfr.sim.stock import StockSimulation
from lfr.tasks import TASKS

PAGE, MARKER = Path("docs/simulation.md"), "engine"
"""Where `table` is shown."""

COMBINATIONS = [(body.name, task) for body in embodiments() for task in TASKS]
WHOLE = ("panda", "sawyer")  # of these, resets, cores, threads and memory too
SKILL = 10  # actions in one call
GOALS = {"lift": 10.0, "stack": 10.0, "pick_place": 8.0, "nut_assembly": 8.0}
BARE_GOAL, CORES_GOAL, RESET_GOAL, MEMORY_GOAL = 0.95, 1.85, 50.0, 50.0
THREADS_GOAL = 1.0  # else the batch should use processes
SEED = 5

Array = NDArray[np.float64]

_mj_step = types.ExternalFunction("mj_step", types.void(types.intp, types.intp))


def demonstration(engine: Simulation, longest: int) -> Array:
    """The scripted expert's actions (n, A) until it succeeds; n a multiple of SKILL."""
    observation, actions, success = engine.reset(SEED), [], False
    expert = Expert(engine.task, engine.layout, ExpertParams())
    controller = engine.embodiment.controller
    while len(actions) < longest and not (success and len(actions) % SKILL == 0):
        actions.append(controller.label(expert.clean(observation), engine.configuration()))
        steps = engine.step(actions[-1])
        observation, success = steps.observations[-1], success or bool(steps.successes[-1])
    return np.array(actions)


def engine_rate(engine: Simulation, actions: Array) -> float:
    """Control steps per second of the engine, a skill to a call."""
    engine.reset(SEED)
    began = time.process_time()
    for t in range(0, len(actions), SKILL):
        engine.step(actions[t : t + SKILL])
    return len(actions) / (time.process_time() - began)


def stock_rate(stock: StockSimulation, actions: Array) -> float:
    """Control steps per second of robosuite's own `step`: observation, reward, success inside."""
    stock.reset(SEED)
    step = stock._env.step
    began = time.process_time()
    for action in actions:
        step(action)
    return len(actions) / (time.process_time() - began)


@numba.njit(nogil=True)
def _record(physics, scene, control, actions, torques):  # type: ignore[no-untyped-def]
    """The engine's substeps, with the actuators' controls written down."""
    row = 0
    for t in range(len(actions)):
        for substep in range(SUBSTEPS):
            libmujoco.mj_step1(physics.model, physics.data)
            if substep == 0:
                set_goal(physics, scene, control, actions[t])
                kernel._advance_gripper(physics, scene, control, actions[t, -1])
            set_torques(physics, scene, control)
            torques[row] = physics.ctrl
            row += 1
            libmujoco.mj_step2(physics.model, physics.data)


@numba.njit(nogil=True)
def _replay(physics, torques):  # type: ignore[no-untyped-def]
    """Nothing but `mj_step`, under controls (n, nu) that were written down."""
    for row in range(len(torques)):
        physics.ctrl[:] = torques[row]
        _mj_step(physics.model, physics.data)


def controls(engine: Simulation, actions: Array) -> Array:
    """What the engine's controller asks of the actuators at each substep, (n, nu)."""
    torques = np.empty((len(actions) * SUBSTEPS, engine._model.nu))
    engine.reset(SEED)
    _record(engine._physics, engine._scene.arrays, engine._control, actions, torques)
    return torques


def bare_rate(engine: Simulation, torques: Array) -> float:
    """Control steps per second of `mj_step` alone, on the engine's model and trajectory."""
    engine.reset(SEED)
    skill = SKILL * SUBSTEPS
    began = time.process_time()
    for row in range(0, len(torques), skill):
        _replay(engine._physics, torques[row : row + skill])
    return len(torques) / SUBSTEPS / (time.process_time() - began)


def check_same_trajectory(engine: Simulation, actions: Array, torques: Array) -> None:
    """Bare `mj_step` must end where the engine ends, or the two do different work."""
    engine_rate(engine, actions)
    position = engine.position()
    bare_rate(engine, torques)
    np.testing.assert_allclose(engine.position(), position, atol=1e-6)


def batch_rate(batch: Batch, actions: Array) -> float:
    """Control steps per second (wall clock) of a batch, every environment the same actions."""
    batch.reset(np.full(len(batch), SEED))
    began = time.perf_counter()
    for t in range(0, len(actions), SKILL):
        batch.step(np.tile(actions[t : t + SKILL], (len(batch), 1, 1)))
    return len(actions) * len(batch) / (time.perf_counter() - began)


class Processes:
    """The batch's other form: `count` simulations shared out over as many processes as threads."""

    def __init__(self, robot: str, task: str, count: int, processes: int, actions: Array) -> None:
        context = multiprocessing.get_context("spawn")
        self.work = len(actions) * count
        self.pipes, self.workers = [], []
        for _ in range(processes):
            ours, theirs = context.Pipe()
            arguments = (robot, task, count // processes, actions, theirs)
            worker = context.Process(target=_serve, args=arguments, daemon=True)
            worker.start()
            self.pipes.append(ours)
            self.workers.append(worker)
        self.rate()

    def rate(self) -> float:
        """Control steps per second (wall clock), until the last process is done."""
        for pipe in self.pipes:
            pipe.send(None)
        for pipe in self.pipes:  # all have reset
            pipe.recv()
        began = time.perf_counter()
        for pipe in self.pipes:
            pipe.send(None)
        for pipe in self.pipes:
            pipe.recv()
        return self.work / (time.perf_counter() - began)

    def close(self) -> None:
        for worker in self.workers:
            worker.terminate()
            worker.join()


def _serve(robot, task, count, actions, pipe):  # type: ignore[no-untyped-def]
    with Batch(robot, task, count, threads=1) as batch:
        while True:
            pipe.recv()
            batch.reset(np.full(count, SEED))
            pipe.send(None)
            pipe.recv()
            for t in range(0, len(actions), SKILL):
                batch.step(np.tile(actions[t : t + SKILL], (count, 1, 1)))
            pipe.send(None)


def resets_per_second(reset: Callable[[int], object], count: int) -> float:
    began = time.process_time()
    for seed in range(count):
        reset(seed)
    return count / (time.process_time() - began)


def memory_of(robot: str, task: str, count: int) -> tuple[float, float]:
    """Memory (MB) of a process with one environment, and with `count`; all have stepped."""
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_occupy, args=(robot, task, count, sender))
    process.start()
    found = receiver.recv()
    process.join()
    return found


def _occupy(robot, task, count, sender):  # type: ignore[no-untyped-def]
    def resident() -> float:
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[1]
        return int(pages) * resource.getpagesize() / 1e6

    engines = [Simulation(robot, task)]
    actions = demonstration(engines[0], 40)
    engine_rate(engines[0], actions)
    one = resident()
    while len(engines) < count:
        engines.append(Simulation(robot, task))
        engine_rate(engines[-1], actions)
    sender.send((one, resident()))


def memory_figure(robot: str, task: str, count: int, repeats: int) -> Figure:
    """MB that `count` environments take over one."""
    found = [memory_of(robot, task, count) for _ in range(repeats)]
    added = sorted(many - one for one, many in found)
    return Figure(
        name=f"memory/{robot}-{task}",
        unit=f"MB of {count} and of 1; the figure is their difference",
        ratio=float(np.median(added)),
        goal=MEMORY_GOAL,
        spread=(added[0], added[-1]),
        ours=float(np.median([many for _, many in found])),
        theirs=float(np.median([one for one, _ in found])),
        at_most=True,
    )


def measure(
    combinations: list[tuple[str, str]], steps: int, repeats: int, environments: int = 64
) -> list[Figure]:
    """All figures of `combinations`, printed as they come."""
    figures: list[Figure] = []

    def add(figure: Figure) -> None:
        show(figure)
        figures.append(figure)

    for robot, task in combinations:
        name, unit = f"{robot}-{task}", "control steps/s"
        engine, stock = (
            Simulation(robot, task),
            StockSimulation(robot, task, object_observation=True),
        )
        actions = demonstration(engine, steps)
        torques = controls(engine, actions)
        check_same_trajectory(engine, actions, torques)

        def ours(engine: Simulation = engine, actions: Array = actions) -> float:
            return engine_rate(engine, actions)

        def theirs(stock: StockSimulation = stock, actions: Array = actions) -> float:
            return stock_rate(stock, actions)

        def bare(engine: Simulation = engine, torques: Array = torques) -> float:
            return bare_rate(engine, torques)

        add(compare(f"stock/{name}", unit, GOALS.get(task, 8.0), ours, theirs, repeats))
        add(compare(f"mj_step/{name}", unit, BARE_GOAL, ours, bare, repeats * 2))
        if robot not in WHOLE:
            continue
        stock._env.hard_reset = False

        def our_resets(engine: Simulation = engine) -> float:
            return resets_per_second(engine.reset, 500)

        def their_resets(stock: StockSimulation = stock) -> float:
            return resets_per_second(lambda seed: stock._env.reset(), 10)

        add(compare(f"reset/{name}", "resets/s", RESET_GOAL, our_resets, their_resets, repeats))
        with Batch(robot, task, 8, threads=2) as two, Batch(robot, task, 8, threads=1) as one:

            def both(batch: Batch = two, actions: Array = actions) -> float:
                return batch_rate(batch, actions)

            def single(batch: Batch = one, actions: Array = actions) -> float:
                return batch_rate(batch, actions)

            add(compare(f"two cores/{name}", unit, CORES_GOAL, both, single, repeats))
            others = Processes(robot, task, 8, 2, actions)
            add(compare(f"threads/{name}", unit, THREADS_GOAL, both, others.rate, repeats))
            others.close()
        add(memory_figure(robot, task, environments, repeats=1 if repeats < 3 else 3))
    return figures


def table(figures: Sequence[Mapping[str, Any]]) -> str:
    """Times stock robosuite's rate, and parts of bare `mj_step`'s, as Markdown."""
    ratios = {figure["name"]: figure["ratio"] for figure in figures}
    lines = [
        f"| `{body.name}` | "
        + " | ".join(
            f"{ratios[f'stock/{body.name}-{task}']:.1f}, "
            f"{100 * ratios[f'mj_step/{body.name}-{task}']:.0f} %"
            for task in TASKS
        )
        + " |"
        for body in embodiments()
    ]
    head = f"| | {' | '.join(task.stock_name for task in TASKS.values())} |"
    return "\n".join([head, "|---" * (len(TASKS) + 1) + "|", *lines])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--steps", type=int, default=150, help="at most, of a demonstration")
    parser.add_argument("--only", help="one combination, e.g. panda-lift")
    parser.add_argument("--out", type=Path, default=FOLDER)
    arguments = parser.parse_args()
    chosen = [pair for pair in COMBINATIONS if arguments.only in (None, "-".join(pair))]
    libmujoco.load()
    print(f"MuJoCo {mujoco.__version__}")
    figures = measure(chosen, arguments.steps, arguments.repeats)
    print(write("simulation", figures, arguments.out))
    if arguments.only is None and arguments.out == FOLDER:
        put(PAGE, MARKER, table([vars(figure) for figure in figures]))


if __name__ == "__main__":
    main()
