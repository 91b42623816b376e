"""An arm that is one number, and policies that move it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lfr.sim.steps import Steps


class Line:
    """Starts at seed % 10 and moves by the sum of the actions; success from 12 on."""

    task = layout = None
    horizon = 8

    def __init__(self) -> None:
        self.seeds: list[int] = []

    def reset(self, seed: int) -> np.ndarray:
        self.seeds.append(seed)
        self.at = float(seed % 10)
        return np.array([self.at])

    def step(self, actions: np.ndarray, stop_on_success: bool = False) -> Steps:
        rows = []
        for action in actions:
            self.at += float(action)
            rows.append(self.at)
            if stop_on_success and self.at >= 12:
                break
        at = np.array(rows)
        return Steps(at[:, None], at, at >= 12, bool((at > 1000).any()))


@dataclass(frozen=True)
class Steady:
    """Moves by ``speed`` in each of the three control steps of a skill."""

    speed: float

    def load(self, robot: str) -> Steady:
        return self

    def reset(self, seed: int) -> None: ...

    def act(self, observation: np.ndarray) -> np.ndarray:
        return np.full(3, self.speed)
