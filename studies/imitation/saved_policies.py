"""Recurrent policies on disk: ``config.json``, which says what they saw, and their tensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lfr.embodiments import embodiment
from lfr.model_files import ModelKind, load_seen_as
from lfr.skills.saved_models import Seen, check_layout
from studies.imitation.recurrent_gmm import RecurrentGMM
from studies.imitation.recurrent_policy import RecurrentPolicy

POLICY = ModelKind(
    "recurrent_gmm",
    RecurrentGMM,
    ("layout_names", "action_dim", "hidden", "layers", "modes", "min_std", "horizon"),
)


def save_policy(folder: Path, policy: RecurrentGMM, seen: Seen) -> None:
    POLICY.save(folder, policy, seen)


def load_policy(folder: Path, layout_names: Sequence[str] | None = None) -> RecurrentGMM:
    """The recurrent policy in a folder.

    Args:
        layout_names: the observation that it will be given; None takes the model's word.

    Raises:
        DataError: no recurrent policy, a damaged one, or one trained on another state layout.
    """
    policy = POLICY.load(folder)
    if layout_names is not None:
        check_layout(folder, policy.layout_names, layout_names)
    return policy


@dataclass(frozen=True)
class RecurrentPolicyFiles:
    """The folder of a recurrent policy; it names the policy in a job."""

    policy: str

    def load(self, robot: str) -> RecurrentPolicy:
        """The policy on any arm; another's actions are done joint by joint.

        Raises:
            DataError: the folder holds no such policy, or a damaged one.
        """
        return RecurrentPolicy(load_policy(Path(self.policy)), embodiment(robot).action.size)


def load_seen(folder: Path) -> Seen:
    """What the policy in a folder has learned from."""
    return load_seen_as(Seen, folder, POLICY)
