"""Policies that have learned on the target, by their folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lfr.artifacts import file_hash
from lfr.transfer.actor import SkillActor
from lfr.transfer.model import load_policy


@dataclass(frozen=True)
class LearnedFiles:
    """A policy saved by `lfr.transfer.model.save_policy`.

    Attributes:
        policy: its folder.
        digest: SHA-256 of its tensors, which tells it from another policy in the same folder.
    """

    policy: str
    digest: str

    @classmethod
    def of(cls, folder: Path) -> LearnedFiles:
        """Raises DataError where there is no model."""
        return cls(str(folder), file_hash(folder / "model.safetensors"))

    def load(self) -> SkillActor:
        """Raises DataError where the folder holds no transferred policy, or a damaged one."""
        actor, _ = load_policy(Path(self.policy))
        return actor
