"""`python -m examples.metaworld_fetch`: record, learn, and say what came of it.

For each seed the project's own stages run in work/examples/metaworld_fetch/seed-<n>, on
demonstrations that all seeds share. What is finished is not run again. All policies are in one
table, results/examples/metaworld_fetch.csv.
"""

from __future__ import annotations

import argparse
import csv
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from lfr.artifacts import provenance, read_json, write_whole

ROOT = Path(__file__).parents[2]
HERE = "examples.metaworld_fetch"
WORK, TABLE = Path("work/examples/metaworld_fetch"), Path("results/examples/metaworld_fetch.csv")
PARAMS = Path(__file__).with_name("params.yaml")
TRANSFER, SOURCE, TARGET, TASK = "pick-fetch-pick_place", "sawyer-metaworld", "fetch", "pick_place"
EPISODES, NOISE = 50, 0.1
DEMONSTRATORS = {
    (SOURCE, "reach"): "metaworld.policies:SawyerReachV3Policy",
    (SOURCE, "push"): "metaworld.policies:SawyerPushV3Policy",
    (SOURCE, "pick_place"): "metaworld.policies:SawyerPickPlaceV3Policy",
    (TARGET, "reach"): f"{HERE}.demonstrators:reach",
    (TARGET, "push"): f"{HERE}.demonstrators:place",
    (TARGET, "pick_place"): f"{HERE}.demonstrators:place",
}
METHODS: dict[str, dict[str, Any]] = {  # what is other than params.yaml says
    "lfr": {},
    "sac": {  # counts control steps where the other counts skills, as studies/evidence has it
        "target_divergence": 6.77, "divergence_limit": 0.0, "warm_up": 2_000,
        "updates_per_skill": 1.0, "batch": 128,
    },
}  # fmt: skip


@dataclass(frozen=True)
class Row:
    """A policy on Fetch, and how it did."""

    method: str
    seed: int
    env_steps: int
    starts: int
    successes: int
    outcomes: str
    revision: str


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    options = parser.parse_args()
    record()
    made_by, rows = provenance()["revision"], list[Row]()
    for seed in range(options.seeds):
        rows += [replace(row, revision=made_by) for row in repetition(seed)]
        write(rows)
    print("\n".join(summary(rows)))


def record() -> None:
    """The demonstrations of both arms that are missing."""
    WORK.mkdir(parents=True, exist_ok=True)
    (WORK / "params.yaml").write_text(PARAMS.read_text())
    for (arm, task), policy in DEMONSTRATORS.items():
        dataset = Path("data/external") / f"{arm.partition('-')[0]}-{task}"
        if not (WORK / dataset).is_dir():
            run(WORK, "lfr.cli", "record", arm, task, "--policy", policy, "--to", dataset,
                "--episodes", EPISODES, "--noise", NOISE)  # fmt: skip


def repetition(seed: int) -> Iterator[Row]:
    """Everything after the recording, once."""
    folder = WORK / f"seed-{seed}"
    (folder / "data").mkdir(parents=True, exist_ok=True)
    link = folder / "data/external"
    if not link.exists():
        link.symlink_to((WORK / "data/external").resolve())
    params = yaml.safe_load(PARAMS.read_text())
    params["seeds"] = {"models": seed, "transfer": [seed]}
    settle(folder, params)
    for arm in (TARGET, SOURCE):
        once(folder, f"results/skills/{arm}.json", "pipeline.skills", "--robot", arm)
    once(folder, f"results/mapping/{TRANSFER}.json", "pipeline.mapping", "--transfer", TRANSFER)
    once(folder, "results/converted.json", f"{HERE}.converted")
    chain = read_json(folder / f"results/mapping/{TRANSFER}.json")["zero_shot"]
    for link_name, found in chain.items():
        yield row(link_name, seed, 0, found)
    yield row("identity, converted", seed, 0, read_json(folder / "results/converted.json"))
    for method, changes in METHODS.items():
        settle(folder, {**params, "transfer": {**params["transfer"], **changes}})
        options = ("--transfer", TRANSFER, "--method", method)
        once(folder, f"results/transfer/{TRANSFER}-{method}.json", "pipeline.transfer", *options)
        once(folder, f"results/evaluate/{TRANSFER}-{method}.json", "pipeline.evaluate", *options)
        judged = read_json(folder / f"results/evaluate/{TRANSFER}-{method}.json")["runs"][0]
        steps = params["transfer"]["steps"]
        yield row(method, seed, steps, judged["success"]["environment"])


def row(method: str, seed: int, steps: int, found: dict[str, Any]) -> Row:
    """A row of the table, of a success rate as reports have it."""
    return Row(method, seed, steps, found["episodes"], found["successes"], found["outcomes"], "")


def settle(folder: Path, params: dict[str, Any]) -> None:
    """The folder's parameters."""
    (folder / "params.yaml").write_text(yaml.safe_dump(params, sort_keys=False))


def once(folder: Path, result: str, module: str, *arguments: str) -> None:
    """A stage, unless its result is there."""
    if not (folder / result).is_file():
        run(folder, module, *arguments)


def run(folder: Path, module: str, *arguments: object) -> None:
    """A command in a folder, which finds this project's modules; its failure ends all."""
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", module, *map(str, arguments)]
    print(f"{folder}: {' '.join(command[2:])}", flush=True)
    subprocess.run(command, cwd=folder, env={**os.environ, "PYTHONPATH": paths}, check=True)


def write(rows: list[Row]) -> None:
    """The table of all policies so far, whole."""
    TABLE.parent.mkdir(parents=True, exist_ok=True)
    with write_whole(TABLE) as partial, partial.open("w", newline="") as file:
        table = csv.DictWriter(file, [*Row.__annotations__], lineterminator="\n")
        table.writeheader()
        table.writerows(vars(one) for one in rows)


def summary(rows: list[Row]) -> Iterator[str]:
    """Each method's successes in percent, by seed."""
    for method in dict.fromkeys(one.method for one in rows):
        rates = [100 * one.successes / one.starts for one in rows if one.method == method]
        yield f"{method:22s}{sum(rates) / len(rates):6.1f}   {' '.join(f'{r:.0f}' for r in rates)}"


if __name__ == "__main__":
    main()
