"""Policies that have learned on the target, by their folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lfr.transfer.actor import SkillActor
from lfr.transfer.model import load_policy


@dataclass(frozen=True)
class LearnedFiles:
    """The folder of a policy saved by `lfr.transfer.model.save_policy`."""

    policy: str

    def load(self) -> SkillActor:
        """Raises DataError where the folder holds no transferred policy, or a damaged one."""
        actor, _ = load_policy(Path(self.policy))
        return actor
