"""What a planted fault is, and where in a dataset it is put."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.checkers.dataset_copy import DatasetCopy

K = 7
"""The episode that has the fault, if one has."""

ROW = 30
"""Its row that has it, if one has."""

Plant = Callable[[DatasetCopy], object]


@dataclass(frozen=True)
class Fault:
    """One fault, in an otherwise clean dataset.

    Attributes:
        group: the kind of thing that is wrong.
        plant: puts it into a copy.
        fits: a regular expression of what is said of it, in whichever checker's words.
        base: the clean dataset, one of `benchmarks.checkers.bases.NAMES`.
    """

    group: str
    plant: Plant
    fits: str
    base: str = "own"


def at(row: int = ROW, episode: int = K) -> Callable[[DatasetCopy], int]:
    """The number of an episode's row among all."""
    return lambda copy: copy.span(episode).start + row
