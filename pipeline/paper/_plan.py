"""Who learns in the evidence, from which seeds and rewards, with which parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from lfr.errors import UnknownNameError
from lfr.params import PARAMS as MAIN
from lfr.params import from_mapping, read_section, read_yaml
from lfr.transfer.params import TransferParams
from pipeline.paper._stage import PARAMS, PaperSeeds


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
        ablated: the transfers of Table III.
        transfer: parameters of `TransferParams` that differ from the main job's.
        of: method -> those that differ for it alone.
    """

    methods: ByGroup
    rewards: ByGroup
    ablated: tuple[str, ...] = ()
    transfer: dict[str, Any] = field(default_factory=dict)
    of: dict[str, dict[str, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for method in self.of:
            self.group(method)

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

    def params_of(
        self, method: str, reward: str, changes: Mapping[str, Any] | None = None
    ) -> TransferParams:
        """The main job's parameters, changed for all methods, for this one, and by ``changes``."""
        own = {**self.transfer, **self.of.get(method, {}), **(changes or {}), "reward": reward}
        main = read_yaml(MAIN).get("transfer", {})
        return from_mapping(TransferParams, {**main, **own}, f"{PARAMS}: learn.of.{method}")


def learning() -> Learning:
    """The section ``learn`` of paper/params.yaml."""
    return read_section(Learning, "learn", PARAMS)
