"""Stage imitate: BC+RNN of the source's demonstrations, judged on the target, for every seed."""

import sys

from lfr.evaluation.imitated import ImitatedFiles, train_and_judge
from lfr.evaluation.trials import JudgeName, Trial
from lfr.imitation.models import ImitationJob
from lfr.imitation.params import ImitationParams
from lfr.params import read_section
from lfr.program import run_stage
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.skills.demonstrations import DATASETS
from lfr.skills.params import SkillsParams
from pipeline._stage import rows_of, unfinished_work
from pipeline.paper._spent import Spent
from pipeline.paper._stage import IMITATORS, PARAMS, judging, paper_seeds, seeds_into

CODE = (
    "lfr.imitation", "lfr.skills.artifacts", "lfr.skills.prior", "lfr.models", "lfr.data",
    "lfr.columns", "lfr.scenarios", "lfr.sim", "lfr.seeds", "lfr.robots", "lfr.tasks",
    "lfr.evaluation.imitated", "lfr.evaluation.rollouts", "lfr.evaluation.trials",
)  # fmt: skip


def main(transfer: str) -> None:
    """Train models/paper-imitators/<transfer>/seed-<n> and judge them on both arms."""
    chosen = transfer_named(transfer)
    scenario = scenario_named(chosen.scenario)
    params = read_section(ImitationParams, "imitate", PARAMS)
    held_out = read_section(SkillsParams, "skills").held_out
    judges = judging()
    seeds = paper_seeds().tables
    inputs = rows_of([DATASETS / f"{chosen.source}-{chosen.task}"])
    work = unfinished_work("paper-imitate", transfer, scenario, params, held_out, *inputs,
                           code=CODE)  # fmt: skip
    spent = Spent(work)
    models = work / "models"
    folders = {seed: str(models / f"seed-{seed}") for seed in seeds}

    policies = {
        seed: ImitationJob(scenario, chosen.source, chosen.task, params, held_out, seed, folder,
                           str(DATASETS))
        for seed, folder in folders.items()
    }  # fmt: skip

    def trial(seed: int, robot: str, count: int, judge: JudgeName) -> Trial:
        return Trial(ImitatedFiles(folders[seed]), robot, chosen.task, count, judge)

    judged: dict[tuple[int, str], Trial] = {}
    for seed in seeds:
        judged[seed, "engine"] = trial(seed, chosen.target, judges.episodes, "engine")
        judged[seed, "robosuite"] = trial(seed, chosen.target, judges.stock_episodes, "robosuite")
        judged[seed, "own_arm"] = trial(seed, chosen.source, judges.episodes, "engine")
    fitted, found = train_and_judge(policies, judged, work, f"imitate {transfer}")

    seeds_into(IMITATORS / transfer, folders)
    datasets = fitted[seeds[0]]["datasets"]
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
        "transfer": transfer,
        "method": "bc_rnn",
        "source": chosen.source,
        "target": chosen.target,
        "task": chosen.task,
        "judge": "engine",
        "runs": runs,
        "datasets": datasets,
    }
    spent.write("imitate", transfer, about)


if __name__ == "__main__":
    sys.exit(run_stage(main))
