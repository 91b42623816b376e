"""Names of the observation's dimensions, and what a run of control steps returns."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lfr.errors import UnknownNameError
from lfr.tasks import Task

STATE_NAMES: tuple[str, ...] = (
    *(f"eef_pos.{axis}" for axis in "xyz"),
    *(f"eef_rot6d.{i}" for i in range(6)),
    "gripper_aperture",
    "gripper_command",
)
"""`observation.state`, the same for every arm, in the base frame: m; columns of R; m; [-1, 1]."""


@dataclass(frozen=True)
class ObservationLayout:
    """The order of an observation vector: `observation.state`, then `environment_state`."""

    state_names: tuple[str, ...]
    environment_names: tuple[str, ...]

    @classmethod
    def of(cls, task: Task) -> "ObservationLayout":
        return cls(STATE_NAMES, task.environment_names)

    @property
    def names(self) -> tuple[str, ...]:
        return self.state_names + self.environment_names

    @property
    def size(self) -> int:
        return len(self.names)

    @property
    def state(self) -> slice:
        """Where `observation.state` stands."""
        return slice(0, len(self.state_names))

    @property
    def environment(self) -> slice:
        """Where `observation.environment_state` stands."""
        return slice(len(self.state_names), self.size)

    def index(self, name: str) -> int:
        """Position of one dimension, such as `cube_pos.z`.

        Raises:
            UnknownNameError: no dimension has that name.
        """
        if name not in self.names:
            raise UnknownNameError("observation dimension", name, self.names)
        return self.names.index(name)

    def slice(self, group: str) -> "slice":
        """Positions of a group such as `cube_to_eef`, all its components.

        Raises:
            UnknownNameError: no group has that name.
        """
        groups = [name.split(".")[0] for name in self.names]
        if group not in groups:
            raise UnknownNameError("observation group", group, tuple(dict.fromkeys(groups)))
        start = groups.index(group)
        return slice(start, start + groups.count(group))


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
