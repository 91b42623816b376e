"""What a run of control steps returns."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Steps:
    """What `n` control steps gave.

    Attributes:
        observations: (n, D), after each step.
        rewards: (n,), robosuite's dense reward after each step.
        successes: (n,) bool, robosuite's own success check after each step.
        diverged: the physics left the finite numbers; the last row is not to be trusted.
    """

    observations: NDArray[np.float64]
    rewards: NDArray[np.float64]
    successes: NDArray[np.bool_]
    diverged: bool = False

    def __len__(self) -> int:
        return len(self.rewards)
