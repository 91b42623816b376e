"""Many simulations of one embodiment in one task, stepped on several threads."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from types import TracebackType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfr.sim.simulation import Simulation
from lfr.sim.steps import Steps
from lfr.spaces import Space


class Batch:
    """`count` simulations side by side; the engine releases the GIL, so threads share the cores.

    Each thread takes the next simulation that waits, so a batch may be larger than the threads and
    an expensive environment (in contact) holds up nobody. A simulation is never in two threads.
    What one environment gives depends on its own seed and actions alone, not on the others.

    Args:
        embodiment, task: as for `Simulation`.
        count: how many.
        threads: at most so many at a time; every core of this process by default.
    """

    def __init__(self, embodiment: str, task: str, count: int, threads: int | None = None) -> None:
        if count < 1:
            raise ValueError(f"{count} simulations asked for, expected at least one")
        self.simulations = tuple(Simulation(embodiment, task) for _ in range(count))
        first = self.simulations[0]
        self.embodiment, self.task, self.horizon = first.embodiment, first.task, first.horizon
        self.layout: Space = first.layout
        threads = min(count, threads or len(os.sched_getaffinity(0)))
        self._pool = ThreadPoolExecutor(threads, "simulation") if threads > 1 else None

    def __len__(self) -> int:
        return len(self.simulations)

    def reset(self, seeds: ArrayLike) -> NDArray[np.float64]:
        """Start an episode in each; seeds (N,); returns observations (N, D)."""
        pairs = zip(self.simulations, np.asarray(seeds), strict=True)
        return np.stack([simulation.reset(int(seed)) for simulation, seed in pairs])

    def step(self, actions: ArrayLike, stop_on_success: bool = False) -> list[Steps]:
        """Apply actions (N, H, A) to all, H control steps each; see `Simulation.step`.

        A simulation that diverges ends its own run with `Steps.diverged`; the others go on.
        """
        return self.step_some(np.arange(len(self)), actions, stop_on_success)

    def step_some(
        self, chosen: ArrayLike, actions: ArrayLike, stop_on_success: bool = False
    ) -> list[Steps]:
        """The same for the simulations with the numbers `chosen` (M,), with actions (M, H, A)."""
        simulations = [self.simulations[i] for i in np.asarray(chosen, dtype=np.int64)]
        actions = np.asarray(actions, dtype=np.float64)
        if len(actions) != len(simulations):
            raise ValueError(f"actions for {len(actions)} of {len(simulations)} simulations")

        def run(simulation: Simulation, its: NDArray[np.float64]) -> Steps:
            return simulation.step(its, stop_on_success)

        mapping = map if self._pool is None else self._pool.map
        return list(mapping(run, simulations, actions))

    def close(self) -> None:
        if self._pool is not None:
            self._pool.shutdown()
            self._pool = None

    def __enter__(self) -> Batch:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
