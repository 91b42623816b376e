"""Parameters of all evaluations: section ``evaluate`` of params.yaml."""

from __future__ import annotations

from dataclasses import dataclass

from lfr.errors import ParameterError
from lfr.evaluation.trials import Simulator


@dataclass(frozen=True)
class EvaluateParams:
    """How policies are judged.

    Attributes:
        episodes: held-out starts per policy, for the chain and for trained policies alike.
        judges: of the trained policies; the first one's word is the result, and it judges the
            policies before any RL too. "robosuite" is stock robosuite's own loop.
    """

    episodes: int = 100
    judges: tuple[Simulator, ...] = ("engine", "robosuite")

    def __post_init__(self) -> None:
        if self.episodes < 1:
            raise ParameterError(f"episodes must be at least 1, found {self.episodes}")
        if not self.judges or len(set(self.judges)) != len(self.judges):
            raise ParameterError(f"judges must name each judge once, found {self.judges}")
