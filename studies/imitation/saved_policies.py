"""Recurrent policies on disk: ``config.json``, which says what they saw, and their tensors."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from lfr.model_files import ModelKind, load_seen_as
from lfr.skills.saved_models import Seen, check_layout
from studies.imitation.recurrent_gmm import RecurrentGMM

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


def load_seen(folder: Path) -> Seen:
    """What the policy in a folder has learned from."""
    return load_seen_as(Seen, folder, POLICY)
