"""BC+RNN of one transfer, trained and judged: what imitate and imitate_plain do alike."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from lfr.evaluation.imitated import ImitatedFiles, train_and_judge
from lfr.evaluation.trials import JudgeName, Trial
from lfr.imitation.models import ImitationJob
from lfr.imitation.params import ImitationParams
from lfr.params import read_section
from lfr.scenarios import Transfer, scenario
from lfr.skills.params import SkillsParams
from pipeline._stage import rows_of, unfinished_work
from pipeline.paper._spent import Spent
from pipeline.paper._stage import PARAMS, judging, seeds_into

CODE = (
    "lfr.imitation", "lfr.skills.artifacts", "lfr.skills.prior", "lfr.models", "lfr.data",
    "lfr.columns", "lfr.scenarios", "lfr.sim", "lfr.seeds", "lfr.robots", "lfr.tasks",
    "lfr.evaluation.imitated", "lfr.policies", "lfr.evaluation.trials",
)  # fmt: skip


def imitate(
    stage: str, transfer: Transfer, datasets: Path, seeds: Sequence[int], policies: Path
) -> None:
    """Train ``policies``/<transfer>/seed-<n> and judge them on both arms, into the stage's results.

    Args:
        datasets: where the source's demonstrations of the new task lie, as <robot>-<task>.
    """
    known = scenario(transfer.scenario)
    params = read_section(ImitationParams, "imitate", PARAMS)
    held_out = read_section(SkillsParams, "skills").held_out
    judges = judging()
    inputs = rows_of([datasets / f"{transfer.source}-{transfer.task}"])
    work = unfinished_work(
        f"paper-{stage.replace('_', '-')}", transfer.name, known, params, held_out, *inputs,
        code=CODE,
    )  # fmt: skip
    spent = Spent(work)
    folders = {seed: str(work / f"models/seed-{seed}") for seed in seeds}
    jobs = {
        seed: ImitationJob(
            known, transfer.source, transfer.task, params, held_out, seed, folder, str(datasets)
        )
        for seed, folder in folders.items()
    }

    def trial(seed: int, robot: str, count: int, judge: JudgeName) -> Trial:
        return Trial(ImitatedFiles(folders[seed]), robot, transfer.task, count, judge)

    judged: dict[tuple[int, str], Trial] = {}
    for seed in seeds:
        judged[seed, "engine"] = trial(seed, transfer.target, judges.episodes, "engine")
        judged[seed, "robosuite"] = trial(seed, transfer.target, judges.stock_episodes, "robosuite")
        judged[seed, "own_arm"] = trial(seed, transfer.source, judges.episodes, "engine")
    fitted, found = train_and_judge(jobs, judged, work, f"{stage} {transfer.name}")

    seeds_into(policies / transfer.name, folders)
    runs = [
        {
            "seed": seed,
            **{key: value for key, value in fitted[seed].items() if key != "datasets"},
            "success": {judge: found[seed, judge] for judge in ("engine", "robosuite")},
            "own_arm": found[seed, "own_arm"],
        }
        for seed in seeds
    ]
    about = {
        "transfer": transfer.name,
        "method": "bc_rnn",
        "source": transfer.source,
        "target": transfer.target,
        "task": transfer.task,
        "judge": "engine",
        "runs": runs,
        "datasets": fitted[seeds[0]]["datasets"],
    }
    spent.write(stage, transfer.name, about)
