"""One small transfer from nothing to a picture, in minutes: `python -m pipeline._demo`.

It runs the main job's own stages, without DVC, in work/demo with the parameters of demo.yaml.
"""

from __future__ import annotations

import os
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path

from lfr.evaluation.chain import chain_trials
from lfr.evaluation.records import chain_records
from lfr.evaluation.trials import Trial
from lfr.params import read_names
from lfr.program import run_program
from lfr.scenarios import Transfer
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.skills.library import pipeline_models
from lfr.skills.skill_policy import SkillFiles
from pipeline import mapping, pack, record, skills
from pipeline._film import film

FOLDER, PARAMS = Path("work/demo"), Path(__file__).with_name("demo.yaml")
PICTURE = Path("results/demo.png")
SHOWN = 0  # the held-out start of the picture

WORDS = {
    "own_arm": "the source's prior and decoder, on its own arm",
    "identity": "the same, its joint motions carried out by the target",
    "no_generator": "the source's prior, the target's decoder",
    "linear": "the same, a linear map between them",
    "mapped": "the same, G between them: where Learn from Robot begins",
    "retarget": "the source's motions of the hand, by both arms' kinematic models",
    "oracle": "the target's own prior, had it been shown the task",
}


def main() -> None:
    """Run it, say what came of it and where to go on."""
    began = time.perf_counter()
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    shutil.copy(PARAMS, FOLDER / "params.yaml")
    os.chdir(FOLDER)
    (name,) = read_names("transfers")
    transfer = transfer_named(name)
    steps = _steps(transfer)
    for number, (what, run) in enumerate(steps, start=1):
        print(f"[{number} of {len(steps)}] {what}", flush=True)
        run()
    film(_shown(transfer), SHOWN, PICTURE)
    print(_told(transfer, time.perf_counter() - began))


def _steps(transfer: Transfer) -> list[tuple[str, Callable[[], None]]]:
    """What is to be done, in words, and the stage that does it."""
    steps: list[tuple[str, Callable[[], None]]] = []
    for robot in (transfer.source, transfer.target):
        for task in (*transfer.common, transfer.task):
            what = f"{robot}: demonstrations of {task}, as MCAP logs and a LeRobot dataset"
            steps.append((what, lambda robot=robot, task=task: _demonstrate(robot, task)))
    for robot in (transfer.source, transfer.target):
        what = f"{robot}: its skills, and a prior of them for each task"
        steps.append((what, lambda robot=robot: skills.main(robot)))
    what = "G, from the skills of one arm to those of the other, and trials"
    return [*steps, (what, lambda: mapping.main(transfer.name))]


def _demonstrate(robot: str, task: str) -> None:
    record.main(robot, task)
    pack.main(robot, task)


def _shown(transfer: Transfer) -> dict[str, Trial]:
    models = pipeline_models(scenario_named(transfer.scenario), transfer)
    folder = Path("models/mapping") / transfer.name
    chain = chain_trials(transfer, models, folder, 1)
    of = models["source"]
    files = SkillFiles(str(of.prior(transfer.task)), str(of.vae()))
    own = Trial(files, transfer.source, transfer.task, 1)
    rows = {"own_arm": own, "identity": chain["identity"], "mapped": chain["mapped"]}
    arms = {name: trial.robot.split("-")[0].capitalize() for name, trial in rows.items()}
    labels = {"own_arm": "source", "identity": "identity", "mapped": "mapped by G"}
    return {f"{arms[name]},\n{label}": rows[name] for name, label in labels.items()}


def _told(transfer: Transfer, seconds: float) -> str:
    chain = chain_records([transfer.name])[transfer.name]["zero_shot"]
    rows = [
        f"  {chain[name]['successes']:3d} of {chain[name]['episodes']}  {words}"
        for name, words in WORDS.items()
    ]
    return "\n".join([
        "",
        f"{transfer.source} was shown {transfer.task}. {transfer.target} was not; both know "
        f"{' and '.join(transfer.common)}.",
        f"Success at {transfer.task} from starts that nobody has seen:",
        *rows,
        "",
        f"{seconds:.0f} s. The picture: {FOLDER / PICTURE}",
        "Look at a demonstration:  lfr view work/demo/data/lerobot/"
        f"{transfer.source}-{transfer.task} --episode 0",
        "With learning on the target after it, and three transfers of three arms:  make repro",
    ])  # fmt: skip


if __name__ == "__main__":
    sys.exit(run_program(main))
