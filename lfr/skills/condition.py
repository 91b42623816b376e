"""What a network sees of the state beside a skill: nothing, or the first dimensions of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from torch import Tensor, nn

from lfr.skills.normalizer import Normalizer
from lfr.spaces import ROBOT_STATE

POSE_NAMES = ROBOT_STATE.names[: ROBOT_STATE.slice("eef_rot6d").stop]
"""Of the hand's position and rotation, with which every observation of this project begins."""


class Condition(NamedTuple):
    """Dimensions of the state, perhaps in the frame of the hand's azimuth (`Normalizer`)."""

    state_names: tuple[str, ...] = ()
    turned: bool = False


GIVEN_NOTHING = Condition()


class Conditioned(nn.Module):
    """A network that sees these dimensions of the state beside what else it is given.

    Attributes:
        feature_size: F, how many numbers it makes of them.
    """

    def __init__(self, state_names: Sequence[str] = (), turned: bool = False) -> None:
        super().__init__()
        self.state_names, self.turned = tuple(state_names), turned
        self.normalizer = Normalizer(state_names, turned=turned) if state_names else None
        self.feature_size = self.normalizer.size if self.normalizer else 0

    def features(self, observations: Tensor) -> Tensor:
        """What it sees of observations (B, D): (B, F), by no trained parameter."""
        seen = observations[:, : len(self.state_names)]
        return seen if self.normalizer is None else self.normalizer(seen)
