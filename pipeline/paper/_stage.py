"""What the evidence's stages do alike: its parameters, and where its models lie."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lfr.errors import ParameterError
from lfr.params import read_section

PARAMS = Path("paper/params.yaml")
MODELS = Path("models/paper")


@dataclass(frozen=True)
class PaperSeeds:
    """Section ``seeds``: whole repetitions, from the split of the demonstrations to learning.

    Attributes:
        tables: of the methods in Tables I and II.
    """

    tables: tuple[int, ...]

    def __post_init__(self) -> None:
        if not self.tables or len(set(self.tables)) != len(self.tables):
            raise ParameterError(f"tables must name each seed once, found {self.tables}")


def paper_seeds() -> PaperSeeds:
    """The section ``seeds`` of paper/params.yaml."""
    return read_section(PaperSeeds, "seeds", PARAMS)


@dataclass(frozen=True)
class Judging:
    """Section ``judging``: how many held-out starts a policy of the evidence is judged on.

    Attributes:
        episodes: by the engine.
        stock_episodes: by stock robosuite, which takes many times as long.
    """

    episodes: int
    stock_episodes: int

    def __post_init__(self) -> None:
        if self.episodes < 1 or self.stock_episodes < 1:
            raise ParameterError(
                f"episodes and stock_episodes must be at least 1, "
                f"found {self.episodes} and {self.stock_episodes}"
            )
