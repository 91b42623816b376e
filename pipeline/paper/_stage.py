"""What the evidence's stages do alike: its parameters, and where its models lie."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from lfr.artifacts import write_whole
from lfr.errors import ParameterError
from lfr.params import read_section

PARAMS = Path("paper/params.yaml")
MODELS = Path("models/paper")
VARIANTS = Path("models/paper-variants")
POLICIES = Path("models/paper-policies")
IMITATORS = Path("models/paper-imitators")


@dataclass(frozen=True)
class PaperSeeds:
    """Section ``seeds``: whole repetitions, from the split of the demonstrations to learning.

    Attributes:
        tables: of the methods in Tables I and II.
        questions: of all else; some of them, since their models are the tables' with a part
            replaced. One mapping leads from each to the next one of tables.
    """

    tables: tuple[int, ...]
    questions: tuple[int, ...]

    def __post_init__(self) -> None:
        for name, seeds in (("tables", self.tables), ("questions", self.questions)):
            if not seeds or len(set(seeds)) != len(seeds):
                raise ParameterError(f"{name} must name each seed once, found {seeds}")
        if len(self.tables) < 2 or not set(self.questions) <= set(self.tables):
            raise ParameterError(
                f"tables must name two seeds or more, and questions some of them, "
                f"found {self.tables} and {self.questions}"
            )

    def after(self, seed: int) -> int:
        """The seed of ``tables`` that follows ``seed``, the first one after the last."""
        return self.tables[(self.tables.index(seed) + 1) % len(self.tables)]


@dataclass(frozen=True)
class Judging:
    """Section ``judging``: of every final policy.

    Attributes:
        episodes: held-out starts, by the engine.
        stock_episodes: how many of these, the first ones, are judged by stock robosuite too.
    """

    episodes: int
    stock_episodes: int

    def __post_init__(self) -> None:
        if self.episodes < 1 or self.stock_episodes < 1:
            raise ParameterError(
                f"episodes and stock_episodes must be at least 1, "
                f"found {self.episodes} and {self.stock_episodes}"
            )


def paper_seeds() -> PaperSeeds:
    """The section ``seeds`` of paper/params.yaml."""
    return read_section(PaperSeeds, "seeds", PARAMS)


def judging() -> Judging:
    """The section ``judging`` of paper/params.yaml."""
    return read_section(Judging, "judging", PARAMS)


def seeds_into(out: Path, folders: Mapping[int, Path | str]) -> None:
    """Copy each seed's finished models to ``out``/seed-<n>, all of them or none."""
    with write_whole(out) as partial:
        for seed, folder in folders.items():
            shutil.copytree(folder, partial / f"seed-{seed}")
