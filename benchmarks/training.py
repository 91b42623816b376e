"""Main memory that training takes on 10,000 episodes of states alone, against 2 GiB.

    python -m benchmarks.training [--episodes 10000] [--steps 300] [--out results/benchmarks]

The stages' own jobs run (`fit_vae`, `fit_priors`, `fit_mapping`: reading and checking the datasets,
training, saving, and the report on held-out episodes) with the parameters of params.yaml, but for
the number of gradient steps: no step keeps anything, so more of them take no more memory. At this
size there are no moved copies: `lfr.skills.rows.MOST_ROWS` leaves no room for them. The skill
VAE and the prior are the target's and learn from one dataset of that size, the mapping from one of
each arm, which hold the same made-up rows. What the mapping needs besides is small and not
measured: the source's models and its demonstrations of the new task, of a few episodes.

Each job has a process of its own, as in the stages, and its peak is the one that they report.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks._datasets import Size, as_of_robot, scratch, write_dataset
from benchmarks._figures import FOLDER, Figure, show, within, write
from lfr.jobs import Job
from lfr.jobs.memory import own_peak
from lfr.jobs.order import Order
from lfr.jobs.pool import run_in_pool
from lfr.jobs.results import Results
from lfr.mapping.mapping_jobs import MappingJob, fit_mapping
from lfr.mapping.mapping_params import MappingParams
from lfr.params import read_section
from lfr.progress import progress
from lfr.scenarios import Role, Scenario, transfers_of, visible_tasks
from lfr.skills.library import transfer_models
from lfr.skills.model_jobs import PriorsTraining, VAETraining, fit_priors, fit_vae
from lfr.skills.skill_params import SkillsParams

GIB = 2**30
GIB_GOAL = 2.0
FEW = Size(episodes=20)
SCENARIO = Scenario("large", common=("lift",), new={"panda": "stack", "sawyer": "pick_place"})
TRANSFER = transfers_of(SCENARIO)[0]  # Panda learns to stack from Sawyer


@dataclass(frozen=True)
class Fits:
    """The jobs of one transfer, in a folder.

    Attributes:
        large: holds the target's dataset of the common task and the source's, both large, and the
            source's of the new task, with few episodes.
        few: holds the source's datasets of both tasks, with few episodes.
    """

    folder: Path
    large: Path
    few: Path
    skills: SkillsParams
    mapping: MappingParams

    def vae(self) -> Job:
        return Job(fit_vae, self._vae("target", self.large))

    def prior(self) -> Job:
        return Job(fit_priors, PriorsTraining(self._vae("target", self.large), ("lift",)))

    def source(self) -> list[Job]:
        vae = self._vae("source", self.few)
        return [Job(fit_vae, vae), Job(fit_priors, PriorsTraining(vae, vae.tasks))]

    def generators(self) -> Job:
        skills = transfer_models(SCENARIO, TRANSFER, self.folder / "skills")
        spec = MappingJob(
            scenario=SCENARIO, transfer=TRANSFER, params=self.mapping,
            held_out=self.skills.held_out, seed=0, skills=skills,
            folder=str(self.folder / "mapping"), datasets=str(self.large),
        )  # fmt: skip
        return Job(fit_mapping, spec)

    def _vae(self, role: Role, datasets: Path) -> VAETraining:
        robot = TRANSFER.source if role == "source" else TRANSFER.target
        tasks = tuple(sorted(visible_tasks(SCENARIO, robot, role)))
        return VAETraining(robot, tasks, self.skills, 0, str(self.folder / "skills"), str(datasets))


def write_datasets(folder: Path, episodes: int) -> tuple[Path, Path]:
    """The two folders of datasets that `Fits` needs: the large ones, and those of few episodes."""
    large, few = folder / "large", folder / "few"
    source, target = TRANSFER.source, TRANSFER.target
    (common,) = TRANSFER.common
    new = f"{source}-{TRANSFER.task}"
    write_dataset(large / f"{target}-{common}", Size(episodes), robot=target, task_name=common)
    as_of_robot(large / f"{target}-{common}", large / f"{source}-{common}", source)
    write_dataset(few / f"{source}-{common}", FEW, robot=source, task_name=common)
    for place in (large, few):
        write_dataset(place / new, FEW, robot=source, task_name=TRANSFER.task)
    return large, few


def fit(jobs: Sequence[Job]) -> int:
    """Carry out jobs one after the other; the most bytes that this process has had so far."""
    for job in jobs:
        job.function(job.spec)
    return own_peak()


def peak(*jobs: Job) -> int:
    """As `fit`, in a process of its own.

    It is forked from a server that has done nothing: the peak of a process that was started by
    `exec` is at least that of the one that started it (Linux's `ru_maxrss` outlives `exec`).
    """
    found: dict[Job, int] = {}
    job = Job(fit, jobs)
    with progress(1) as bar:
        run_in_pool(Order([job]), 1, Results(bar, found.__setitem__))
    return found[job]


def measure(folder: Path, episodes: int, steps: int) -> list[Figure]:
    """All figures, each printed as soon as it is known."""
    skills, mapping = read_section(SkillsParams, "skills"), read_section(MappingParams, "mapping")
    skills = replace(
        skills, vae=replace(skills.vae, steps=steps), prior=replace(skills.prior, steps=steps)
    )
    large, few = write_datasets(folder, episodes)
    fits = Fits(folder / "models", large, few, skills, replace(mapping, steps=steps))
    figures: list[Figure] = []

    def add(name: str, job: Job) -> None:
        label, unit = f"memory/{name}_of_{episodes}_episodes", f"GiB at most, {steps} steps"
        figures.append(within(label, unit, GIB_GOAL, [peak(job) / GIB]))
        show(figures[-1])

    add("skill_vae", fits.vae())
    add("prior", fits.prior())
    peak(*fits.source())
    add("mapping_of_two_arms", fits.generators())
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--episodes", type=int, default=10_000)
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument("--out", type=Path, default=FOLDER)
    arguments = parser.parse_args()
    with scratch() as folder:
        figures = measure(folder, arguments.episodes, arguments.steps)
    print(write("training", figures, arguments.out))


if __name__ == "__main__":
    main()
