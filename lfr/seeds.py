"""Seeds of episodes, in ranges that cannot meet: no policy is judged on a start it has seen."""

from __future__ import annotations

from typing import Literal

from lfr.errors import LfrError

Use = Literal["demonstration", "learning", "held-out"]

PER_USE = 1_000_000
FIRST: dict[Use, int] = {"demonstration": 0, "learning": 1_000_000, "held-out": 2_000_000}


def episode_seed(use: Use, index: int) -> int:
    """The seed of the ``index``-th episode of a use.

    Raises:
        LfrError: the index does not fit into the use's range of a million seeds.
    """
    if not 0 <= index < PER_USE:
        raise LfrError(f"index {index} of {use} seeds; expected 0 to {PER_USE - 1}")
    return FIRST[use] + index


def use_of_seed(seed: int) -> Use:
    """Which use a seed belongs to, so that a dataset or a report can be checked.

    Raises:
        LfrError: the seed is in no range.
    """
    for use, first in FIRST.items():
        if first <= seed < first + PER_USE:
            return use
    raise LfrError(f"seed {seed} is in no range; expected 0 to {3 * PER_USE - 1}")
