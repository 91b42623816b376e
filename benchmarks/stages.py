"""What a stage costs: against another revision, and in a yardstick that other machines have too.

    python -m benchmarks.stages [--before REVISION] [--repeats 1] [--out results/benchmarks]

The stages skills, mapping and transfer of the first transfer of params.yaml, and of its target, run
as `dvc repro` runs them, with each revision's own parameters, in clones of this repository: of HEAD
and, if asked for, of another revision that has the same transfer, alternately. Datasets and the
models that a stage needs are the project's own, so `dvc repro` comes first. A stage's time is also
given in yardsticks: one is the time of 100 products of two 1024 x 1024 matrices of float32 on one
core, taken right before the stage. It needs a machine that is otherwise quiet.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import torch

from benchmarks._datasets import scratch
from benchmarks._figures import FOLDER, Figure, show, within, write
from lfr.artifacts import read_json
from lfr.params import read_names
from lfr.scenarios import transfer

TRANSFER = transfer(read_names("transfers")[0])
STAGES = {
    "skills": ("--robot", TRANSFER.target),
    "mapping": ("--transfer", TRANSFER.name),
    "transfer": ("--transfer", TRANSFER.name, "--method", "lfr"),
}
RESULTS = {
    "skills": TRANSFER.target, "mapping": TRANSFER.name, "transfer": f"{TRANSFER.name}-lfr",
}  # fmt: skip
GOALS = {"skills": 0.5, "mapping": 0.5, "transfer": 2 / 3}
GIB = 2**30
GIB_GOAL = 3.0  # of any one process


@dataclass(frozen=True)
class Cost:
    """One run of a stage: wall-clock, the same in yardsticks, and most memory of one process."""

    seconds: float
    yardsticks: float
    gib: float


def yardstick() -> float:
    """Seconds of a fixed piece of arithmetic on one core."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    a, b = torch.randn(2, 1024, 1024)
    out = torch.empty(1024, 1024)
    torch.mm(a, b, out=out)
    began = time.perf_counter()
    for _ in range(100):
        torch.mm(a, b, out=out)
    seconds = time.perf_counter() - began
    torch.set_num_threads(before)
    return seconds


def clone(folder: Path, revision: str) -> Path:
    """A clone of this repository at a revision, with its data and models, kernel compiled."""
    subprocess.run(["git", "clone", "--quiet", "--shared", ".", str(folder)], check=True)
    subprocess.run(["git", "checkout", "--quiet", revision], cwd=folder, check=True)
    (folder / "data").mkdir(exist_ok=True)
    (folder / "data/lerobot").symlink_to(Path("data/lerobot").resolve())
    for models in ("skills", f"mapping/{TRANSFER.name}"):
        shutil.copytree(Path("models") / models, folder / "models" / models)
    compile_kernel = "from lfr.sim.simulation import Simulation; Simulation('panda', 'lift')"
    subprocess.run([sys.executable, "-c", compile_kernel], cwd=folder, check=True)
    return folder


def run(stage: str, project: Path) -> Cost:
    """A stage from nothing, in a clone."""
    shutil.rmtree(project / "work", ignore_errors=True)
    unit, began = yardstick(), time.perf_counter()
    command = [sys.executable, "-m", f"pipeline.{stage}", *STAGES[stage]]
    subprocess.run(command, cwd=project, check=True, capture_output=True)
    seconds = time.perf_counter() - began
    found = read_json(project / "results" / stage / f"{RESULTS[stage]}.json")
    return Cost(seconds, seconds / unit, found["peak_memory"] / GIB)


def measure(folder: Path, before: str | None, repeats: int) -> list[Figure]:
    """All figures, each printed as soon as it is known."""
    sides = [clone(folder / "now", "HEAD")]
    if before:
        sides.append(clone(folder / "before", before))
    figures: list[Figure] = []
    for stage in STAGES:
        runs = [[run(stage, side) for side in sides] for _ in range(repeats)]
        figures += figures_of(stage, runs)
    return figures


def figures_of(stage: str, runs: list[list[Cost]]) -> list[Figure]:
    """Of one stage, from each repeat's costs: now and, if there is one, before."""
    now = [costs[0] for costs in runs]
    figures = [within(f"memory/{stage}", "GiB", GIB_GOAL, [cost.gib for cost in now])]
    if len(runs[0]) > 1:
        ratios = sorted(ours.seconds / theirs.seconds for ours, theirs in runs)
        figures.append(
            Figure(
                name=f"before/{stage}",
                unit="seconds",
                ratio=statistics.median(ratios),
                goal=GOALS[stage],
                spread=(ratios[0], ratios[-1]),
                ours=statistics.median(cost.seconds for cost in now),
                theirs=statistics.median(costs[1].seconds for costs in runs),
                at_most=True,
            )
        )
    units = sorted(cost.yardsticks for cost in now)
    name, unit = f"yardstick/{stage}", "yardsticks, and seconds of one"
    one = statistics.median(cost.seconds / cost.yardsticks for cost in now)
    middle, spread = statistics.median(units), (units[0], units[-1])
    figures.append(Figure(name, unit, middle, None, spread, middle, one))
    for figure in figures:
        show(figure)
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--before", help="a revision to compare with")
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--out", type=Path, default=FOLDER)
    arguments = parser.parse_args()
    with scratch() as folder:
        figures = measure(folder, arguments.before, arguments.repeats)
    print(write("stages", figures, arguments.out))


if __name__ == "__main__":
    main()
