"""The stages' metrics under ``results/``, gathered: one record per run, one chain per transfer."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.artifacts import read_json
from lfr.errors import DataError

RESULTS = Path("results")
CHAIN = (
    "own_arm", "identity", "no_generator", "recoded", "linear", "mapped", "retarget", "oracle",
)  # fmt: skip
"""The links, as `lfr.evaluation.chain` describes them."""

STAGES = ("record", "pack", "skills", "mapping", "transfer", "evaluate")
Record = dict[str, Any]


@dataclass(frozen=True)
class Run:
    """What one transfer and method left under ``results/transfer`` and ``results/evaluate``."""

    learned: dict[str, Any]
    judged: dict[str, Any]


@dataclass(frozen=True)
class StageRun:
    """What a stage says of its own run for one key.

    Attributes:
        seconds: wall-clock.
        peak_memory: bytes, of its largest process; None where it was not measured.
        provenance: as `lfr.artifacts.provenance` has it; empty where it was not noted.
    """

    seconds: float
    peak_memory: int | None
    provenance: dict[str, Any]

    @property
    def revision(self) -> str:
        """The git revision, shortened, with a plus sign where the sources differed from it."""
        revision = str(self.provenance.get("revision") or "?")[:12]
        return revision + "+" * bool(self.provenance.get("modified"))


def read_runs(
    transfers: Sequence[str], methods: Sequence[str], results: Path = RESULTS
) -> list[Run]:
    """Every transfer by every method.

    Raises:
        DataError: a stage has left nothing there, or other seeds than the other one.
    """
    runs = []
    for name in (f"{transfer}-{method}" for transfer in transfers for method in methods):
        learned = read_json(results / "transfer" / f"{name}.json")
        file = results / "evaluate" / f"{name}.json"
        judged = read_json(file)
        expected, found = ([run["seed"] for run in part["runs"]] for part in (learned, judged))
        if found != expected:
            raise DataError("other seeds than were trained", file=file, found=found,
                            expected=expected)  # fmt: skip
        runs.append(Run(learned, judged))
    return runs


def transfer_records(runs: Iterable[Run]) -> list[Record]:
    """One record for each run: what it reached, by whose judgement, and what it came from.

    ``zero_shot`` and ``success`` are rates by the first judge over ``episodes`` held-out starts;
    ``zero_shot_interval`` and ``success_interval`` are their Wilson intervals of 95 %.
    ``other_judges`` holds the rates of the final policy by any further judge.
    """
    records = []
    for run in runs:
        about, provenance = run.learned, run.learned["provenance"]
        for learned, judged in zip(about["runs"], run.judged["runs"], strict=True):
            judge = run.judged["judge"]
            zero_shot, success = judged["zero_shot"], judged["success"][judge]
            records.append(
                {
                    "transfer": about["transfer"],
                    "method": about["method"],
                    "reward": about["reward"],
                    "seed": learned["seed"],
                    "env_steps": learned["env_steps"],
                    "zero_shot": zero_shot["rate"],
                    "success": success["rate"],
                    "episodes": success["episodes"],
                    "judge": judge,
                    "zero_shot_interval": [zero_shot["low"], zero_shot["high"]],
                    "success_interval": [success["low"], success["high"]],
                    "other_judges": {
                        name: found["rate"]
                        for name, found in judged["success"].items()
                        if name != judge
                    },
                    "revisions": {
                        "git": provenance["revision"],
                        "modified": provenance["modified"],
                        "datasets": about["datasets"],
                    },
                }
            )
    return records


def chain_records(transfers: Sequence[str], results: Path = RESULTS) -> dict[str, Record]:
    """Each transfer's chain: its arms and task, and zero-shot success link by link.

    The first and the last link are priors on their own arm, which the skills stage has measured for
    every transfer that shares them. A link that the arms' actions do not allow is left out.
    """
    records = {}
    for transfer in transfers:
        found = read_json(results / "chain" / f"{transfer}.json")
        zero_shot = dict(found["zero_shot"])
        for link, role in (("own_arm", "source"), ("oracle", "oracle")):
            robot, _, tasks = found["skills"][role].partition("/")
            models = read_json(results / "skills" / f"{robot}.json")["models"]
            zero_shot[link] = models[tasks]["prior"][found["task"]]["own_arm"]
        about = {key: found[key] for key in ("source", "target", "task")}
        links = [link for link in CHAIN if link in zero_shot]
        records[transfer] = {**about, "zero_shot": {link: zero_shot[link] for link in links}}
    return records


def stage_runs(results: Path = RESULTS) -> dict[str, dict[str, StageRun]]:
    """The last run of every stage for every key: stage -> key -> run."""
    return {
        stage: {
            file.stem: _run(read_json(file)) for file in sorted((results / stage).glob("*.json"))
        }
        for stage in STAGES
    }


def _run(metrics: dict[str, Any]) -> StageRun:
    return StageRun(metrics["seconds"], metrics.get("peak_memory"), metrics.get("provenance") or {})
