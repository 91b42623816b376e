"""What a learning run tells whoever listens: episodes, updates, evaluations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class EpisodeRecord:
    """A finished learning episode."""

    env_steps: int  # on the axis, when it ended
    seed: int
    length: int  # control steps
    total_reward: float
    success: bool
    valid: bool  # False if the simulation diverged


@dataclass(frozen=True)
class CurvePoint:
    """One evaluation with the policy's mean; the rest are means over the updates since the last.

    None where there was nothing to average.
    """

    env_steps: int
    updates: int
    episodes: int
    success: float  # fraction, at any step of the episode
    mean_return: float  # undiscounted sum of the skills' rewards, until success
    mean_length: float  # control steps
    learning_success: float | None  # of the episodes that were learned from, with sampled skills
    kl: float | None  # as Eq. 9 charges it: tempered (`lfr.transfer.distribution.tempered`)
    alpha: float | None
    sigma: float | None
    q: float | None
    critic_loss: float | None
    policy_loss: float | None


class Observer:
    """Listens to a run and does nothing; override what is of interest.

    It is called between two rounds of the loop and may not change what it is given: a run with an
    observer is bit for bit the run without one.
    """

    def on_episode(self, episode: EpisodeRecord) -> None:
        """A learning episode ended."""

    def on_update(self, env_steps: int, updates: int, info: Mapping[str, float]) -> None:
        """A round of updates was made; ``info`` holds their means."""

    def on_evaluation(self, point: CurvePoint) -> None:
        """The policy was evaluated."""

    def on_progress(self, env_steps: int, total: int) -> None:
        """``env_steps`` of ``total`` are done."""
