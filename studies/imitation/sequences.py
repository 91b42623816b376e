"""Training data of a recurrent policy: runs of consecutive observations and their actions."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor

from lfr.data.windows import DemonstrationSet


class SequenceBatch(NamedTuple):
    """`observations` (B, T, D) and `actions` (B, T, A); past an episode's end its last frame."""

    observations: Tensor
    actions: Tensor


class Sequences:
    """The sequences of ``length`` control steps that start at every frame of the episodes.

    Past an episode's end its last frame is repeated, and counts in the loss like any other, as
    robomimic's ``pad_seq_length`` does it. Beside the actions of `lfr.data.windows.Windows` these
    have the observation of every step.
    """

    def __init__(self, demonstrations: DemonstrationSet, length: int) -> None:
        if length < 1:
            raise ValueError(f"a sequence has at least one step, found {length}")
        self.demonstrations = demonstrations
        ends = (demonstrations.starts[1:] - 1).repeat_interleave(demonstrations.lengths)  # (N,)
        rows = torch.arange(len(demonstrations))[:, None] + torch.arange(length)
        self._rows = rows.minimum(ends[:, None])  # (N, T)

    def __len__(self) -> int:
        return len(self._rows)

    def gather(self, index: Tensor) -> SequenceBatch:
        """The sequences of these numbers, (B,) int64 in [0, len)."""
        rows = self._rows[index]
        return SequenceBatch(
            self.demonstrations.observations[rows], self.demonstrations.actions[rows]
        )
