"""results/paper, read: one flat list of runs, the zero-shot links, and how the stages ran.

The evidence comes in over hours. What is not there yet is simply missing here.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lfr.artifacts import read_json
from lfr.errors import DataError
from lfr.evaluation.evidence.aggregate import Seeds
from lfr.evaluation.evidence.curves import LEVELS, Curve, read_curves
from lfr.evaluation.evidence.links import Links, links_of
from lfr.evaluation.evidence.names import METHODS, REWARDS, in_order
from lfr.evaluation.evidence.reference import Reference, read_reference
from lfr.evaluation.records import RESULTS, StageRun
from lfr.evaluation.statistics import success_of

PAPER = RESULTS / "paper"
# as they are run
STAGES = (
    "models", "variants", "zero_shot", "imitate", "learn", "reference", "plain_demonstrations",
    "plain", "learn_plain", "imitate_plain", "plain_parts",
)  # fmt: skip
STOCK = "robosuite"
UNVARIED = ("lfr", "ap", "sac", "no_generator", "spirl_no_prior")  # of the seed's models alone


@dataclass(frozen=True)
class SeedRun:
    """What one method reached on one transfer with one seed, under one reward.

    Attributes:
        reward: None for a method that has none.
        successes, episodes: of the final policy on held-out starts, by the first judge.
        zero_shot: rate on the same starts before any learning; None where it has no such state.
        stock: rate of the final policy in stock robosuite; None where it was not judged there.
        stock_episodes: the starts that robosuite judged, the first ones of ``episodes``.
        env_steps: of learning; None for a method that takes none.
        seconds: of learning.
        models: the start of the SHA-256 of what it began with; None of a method that has none.
        curve: of the running evaluations.
    """

    transfer: str
    method: str
    reward: str | None
    seed: int
    successes: int
    episodes: int
    zero_shot: float | None = None
    stock: float | None = None
    stock_episodes: int | None = None
    env_steps: int | None = None
    seconds: float | None = None
    models: str | None = None
    curve: Curve | None = None

    @property
    def success(self) -> float:
        return self.successes / self.episodes

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's, of 95 %: of the episodes, not of the training."""
        found = success_of(self.successes, self.episodes)
        return found.low, found.high

    @property
    def auc(self) -> float | None:
        return self.curve.area if self.curve else None

    @property
    def steps_to(self) -> tuple[int | None, ...]:
        """Environment steps to each of `LEVELS`; empty without a curve."""
        return tuple(self.curve.first_at(level) for level in LEVELS) if self.curve else ()


@dataclass(frozen=True)
class Evidence:
    """All that results/paper holds.

    Attributes:
        links: transfer -> links.
        plain: the same of models that learned from plain demonstrations.
        plain_runs: of methods that began with these models, and of imitation of
            plain demonstrations.
        parts: transfer -> which parts of the plain choices alone were plain -> links.
        stages: stage -> key -> its last run.
        reference: SAC beside robosuite-benchmark's; None before both are there.
    """

    runs: tuple[SeedRun, ...] = ()
    links: dict[str, Links] = field(default_factory=dict)
    plain: dict[str, Links] = field(default_factory=dict)
    plain_runs: tuple[SeedRun, ...] = ()
    parts: dict[str, dict[tuple[str, ...], Links]] = field(default_factory=dict)
    stages: dict[str, dict[str, StageRun]] = field(default_factory=dict)
    reference: Reference | None = None

    def of(self, transfer: str, method: str, reward: str | None) -> list[SeedRun]:
        """A method's runs under a reward, by rising seed; a method without one fits any."""
        return _of(self.runs, transfer, method, reward)

    def plain_of(self, transfer: str, method: str, reward: str | None) -> list[SeedRun]:
        """The same of ``plain_runs``."""
        return _of(self.plain_runs, transfer, method, reward)

    def link(self, transfer: str, link: str) -> Seeds | None:
        """A zero-shot link's successes; None where it was not measured."""
        found = self.links.get(transfer)
        return found.links.get(link) if found else None

    def methods(self, transfers: Iterable[str] | None = None) -> list[str]:
        """Methods with a run on any of the transfers (of all of them), in the tables' order."""
        wanted = None if transfers is None else set(transfers)
        found = (run.method for run in self.runs if wanted is None or run.transfer in wanted)
        return in_order(found, METHODS)

    def rewards(self) -> list[str]:
        """Rewards that a run was trained on; the sparse one where none was yet."""
        found = in_order((run.reward for run in self.runs if run.reward), REWARDS)
        return found or list(REWARDS[:1])


def _of(runs: Iterable[SeedRun], transfer: str, method: str, reward: str | None) -> list[SeedRun]:
    return [
        run for run in runs
        if (run.transfer, run.method) == (transfer, method) and run.reward in (reward, None)
    ]  # fmt: skip


def counts(runs: Sequence[SeedRun]) -> Seeds:
    """What the runs reached, for the statistics.

    Raises:
        ValueError: there is no run.
    """
    return Seeds(tuple(run.successes for run in runs), tuple(run.episodes for run in runs))


def of_seeds(runs: Sequence[SeedRun], seeds: Iterable[int]) -> list[SeedRun]:
    """Those runs whose seed is among ``seeds``."""
    wanted = set(seeds)
    return [run for run in runs if run.seed in wanted]


def made_again(evidence: Evidence, transfer: str) -> bool:
    """Whether runs that begin with the same models, by their seed, began with different ones."""
    found: dict[int, set[str]] = {}
    for run in evidence.runs:
        if run.transfer == transfer and run.method in UNVARIED and run.models:
            found.setdefault(run.seed, set()).add(run.models)
    return any(len(models) > 1 for models in found.values())


def read_evidence(paper: Path = PAPER) -> Evidence:
    """What the stages have left under ``paper`` so far.

    Raises:
        DataError: a file is cut off, is not what its stage writes, or counts one seed twice.
    """
    runs = _ordered(paper, [*_imitated(paper / "imitate"), *_learned(paper / "learn")])
    plain_runs = _ordered(
        paper, [*_imitated(paper / "imitate_plain"), *_learned(paper / "learn_plain")]
    )
    reference = read_reference(paper / "reference" / "lift-panda.csv")
    links, plain = (_all_links(paper / stage) for stage in ("zero_shot", "plain"))
    parts = _parts(paper / "plain_parts")
    return Evidence(runs, links, plain, plain_runs, parts, _stages(paper), reference)


def _ordered(paper: Path, runs: Sequence[SeedRun]) -> tuple[SeedRun, ...]:
    keys = [(run.transfer, run.method, run.reward or "", run.seed) for run in runs]
    twice = sorted({key for key in keys if keys.count(key) > 1})
    if twice:
        raise DataError("a seed is there twice", file=paper, found=twice[0], expected="one run")
    return tuple(run for _, run in sorted(zip(keys, runs, strict=True), key=lambda one: one[0]))


def _learned(folder: Path) -> list[SeedRun]:
    runs = []
    for file, content in _files(folder):
        curves = read_curves(file.with_suffix(".csv"))
        # Where a run starts does not depend on its reward, so one is judged for all of them.
        befores = {run["seed"]: run["zero_shot"] for run in content["runs"] if run["zero_shot"]}
        for run in content["runs"]:
            curve = curves.get((run["reward"], run["seed"]))
            if curve is None:
                raise DataError("no curve of a run", file=file.with_suffix(".csv"),
                                expected=f"reward {run['reward']}, seed {run['seed']}")  # fmt: skip
            before = befores.get(run["seed"])
            learned = {"zero_shot": before["rate"] if before else None, "curve": curve,
                       "env_steps": run["env_steps"], "reward": run["reward"]}  # fmt: skip
            runs.append(_seed_run(content, run, learned))
    return runs


def _imitated(folder: Path) -> list[SeedRun]:
    return [
        _seed_run(content, run, {"reward": None})
        for _, content in _files(folder)
        for run in content["runs"]
    ]


def _seed_run(about: dict[str, Any], run: dict[str, Any], learned: dict[str, Any]) -> SeedRun:
    judged, stock = run["success"][about["judge"]], run["success"].get(STOCK)
    return SeedRun(
        transfer=about["transfer"], method=about["method"], seed=run["seed"],
        successes=judged["successes"], episodes=judged["episodes"],
        stock=stock["rate"] if stock else None,
        stock_episodes=stock["episodes"] if stock else None, seconds=run.get("seconds"),
        models=run.get("models"), **learned,
    )  # fmt: skip


def _all_links(folder: Path) -> dict[str, Links]:
    """transfer -> links"""
    found = [links_of(content) for _, content in _files(folder)]
    return {one.transfer: one for one in found}


def _parts(folder: Path) -> dict[str, dict[tuple[str, ...], Links]]:
    found: dict[str, dict[tuple[str, ...], Links]] = {}
    for _, content in _files(folder):
        found.setdefault(content["transfer"], {})[tuple(content["set_back"])] = links_of(content)
    return found


def _stages(paper: Path) -> dict[str, dict[str, StageRun]]:
    return {
        stage: {
            file.stem: StageRun(
                made["seconds"], made.get("peak_memory"), made.get("provenance") or {}
            )
            for file, made in files
        }
        for stage, files in ((stage, _files(paper / stage)) for stage in STAGES)
        if files
    }


def _files(folder: Path) -> list[tuple[Path, dict[str, Any]]]:
    return [(file, read_json(file)) for file in sorted(folder.glob("*.json"))]
