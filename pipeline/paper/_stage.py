"""What the evidence's stages do alike: its parameters, and where its models lie."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lfr.errors import ParameterError, UnknownNameError
from lfr.params import PARAMS as MAIN
from lfr.params import from_mapping, read_section, read_yaml
from lfr.transfer.params import TransferParams

PARAMS = Path("paper/params.yaml")
MODELS = Path("models/paper")
VARIANTS = Path("models/paper-variants")
POLICIES = Path("models/paper-policies")


@dataclass(frozen=True)
class PaperSeeds:
    """Section ``seeds``: whole repetitions, from the split of the demonstrations to learning.

    Attributes:
        tables: of the methods in Tables I and II.
        questions: of all others.
    """

    tables: tuple[int, ...]
    questions: tuple[int, ...]

    def __post_init__(self) -> None:
        for name in ("tables", "questions"):
            seeds = getattr(self, name)
            if not seeds or len(set(seeds)) != len(seeds):
                raise ParameterError(f"{name} must name each seed once, found {seeds}")
        if not set(self.questions) <= set(self.tables):
            raise ParameterError(f"questions must be among tables, found {self.questions}")


@dataclass(frozen=True)
class Judging:
    """Section ``judging``: of every final policy.

    Attributes:
        episodes: held-out starts, by the engine.
        stock_episodes: how many of these, the first ones, are judged by stock robosuite too.
    """

    episodes: int
    stock_episodes: int


@dataclass(frozen=True)
class ByGroup:
    """Names for each group of methods: the paper's tables, its ablations, the questions."""

    tables: tuple[str, ...]
    ablations: tuple[str, ...]
    questions: tuple[str, ...]


@dataclass(frozen=True)
class Learning:
    """Section ``learn``: who learns, with which rewards, and in what a method differs.

    Attributes:
        methods, rewards: by group.
        transfer: parameters of `TransferParams` that differ from the main job's.
        of: method -> those that differ for it alone.
    """

    methods: ByGroup
    rewards: ByGroup
    transfer: dict[str, Any] = field(default_factory=dict)
    of: dict[str, dict[str, Any]] = field(default_factory=dict)

    def group(self, method: str) -> str:
        """The group that a method belongs to.

        Raises:
            UnknownNameError: none.
        """
        for name, methods in vars(self.methods).items():
            if method in methods:
                return name
        known = [one for methods in vars(self.methods).values() for one in methods]
        raise UnknownNameError("method", method, known)

    def rewards_of(self, method: str) -> tuple[str, ...]:
        return getattr(self.rewards, self.group(method))

    def seeds_of(self, method: str, seeds: PaperSeeds) -> tuple[int, ...]:
        return seeds.tables if self.group(method) == "tables" else seeds.questions

    def params_of(self, method: str, reward: str) -> TransferParams:
        """The main job's parameters, changed for all methods and for this one."""
        own = {**self.transfer, **self.of.get(method, {}), "reward": reward}
        main = read_yaml(MAIN).get("transfer", {})
        return from_mapping(TransferParams, {**main, **own}, f"{PARAMS}: learn.of.{method}")


def paper_seeds() -> PaperSeeds:
    """The section ``seeds`` of paper/params.yaml."""
    return read_section(PaperSeeds, "seeds", PARAMS)


def judging() -> Judging:
    """The section ``judging`` of paper/params.yaml."""
    return read_section(Judging, "judging", PARAMS)


def learning() -> Learning:
    """The section ``learn`` of paper/params.yaml."""
    return read_section(Learning, "learn", PARAMS)
