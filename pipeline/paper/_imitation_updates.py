r"""What BC+RNN gains with more updates: likelihood and success on learning starts, on both arms.

    python -m pipeline.paper._imitation_updates --transfer s1-sawyer-stack \
        --updates 300 1000 2000 4000 --rate 1e-3

Each policy is trained as the stage ``imitate`` trains that of the first seed, but for
``imitate.updates`` and ``imitate.learning_rate``, and tried on starts that are not held out. Writes
results/studies/imitation-updates-<transfer>.json; killed, it goes on.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lfr.artifacts import provenance, write_json
from lfr.evaluation.statistics import success_of
from lfr.imitation.artifacts import load_policy
from lfr.imitation.models import ImitationJob, fit_imitation
from lfr.imitation.params import ImitationParams
from lfr.imitation.policy import RecurrentPolicy
from lfr.jobs import run_jobs
from lfr.params import read_section
from lfr.policies import roll_out
from lfr.scenarios import scenario, transfer
from lfr.seeds import episode_seed
from lfr.skills.demonstrations import DATASETS
from lfr.skills.params import SkillsParams
from pipeline._stage import rows_of, unfinished_work
from pipeline.paper._imitation import CODE
from pipeline.paper._stage import PARAMS, paper_seeds

FIRST = 600_000  # of the learning starts: far from those that transfer learning uses


@dataclass(frozen=True)
class Try:
    """One policy, and how often it is tried on its own arm and on the target."""

    job: ImitationJob
    target: str
    episodes: int


def run_try(one: Try) -> dict[str, Any]:
    """Train the policy and roll it out on both arms; ``cpu``: seconds until it was saved."""
    from lfr.sim.simulation import simulation

    began = time.process_time()
    fitted = fit_imitation(one.job)
    cpu = time.process_time() - began
    policy = RecurrentPolicy(load_policy(Path(one.job.folder)))
    starts = [episode_seed("learning", FIRST + i) for i in range(one.episodes)]
    success = {}
    for name, robot in (("own_arm", one.job.robot), ("target", one.target)):
        outcomes = roll_out(policy, simulation(robot, one.job.task), starts)
        success[name] = vars(success_of(sum(o.success for o in outcomes), one.episodes))
    rate = one.job.params.learning_rate
    return {"learning_rate": rate, **fitted, "cpu": round(cpu, 1), **success}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--transfer", required=True)
    parser.add_argument("--updates", type=int, nargs="+", required=True)
    parser.add_argument("--rate", type=float, nargs="+", required=True)
    parser.add_argument("--episodes", type=int, default=40)
    options = parser.parse_args()
    chosen = transfer(options.transfer)
    known = scenario(chosen.scenario)
    params = read_section(ImitationParams, "imitate", PARAMS)
    held_out = read_section(SkillsParams, "skills").held_out
    seed = paper_seeds().tables[0]
    inputs = rows_of([DATASETS / f"{chosen.source}-{chosen.task}"])
    work = unfinished_work("imitation-updates", chosen.name, known, held_out, *inputs, code=CODE)
    tries = [
        Try(
            ImitationJob(
                known, chosen.source, chosen.task,
                replace(params, updates=updates, learning_rate=rate), held_out, seed,
                str(work / f"updates-{updates}-rate-{rate}"), str(DATASETS),
            ),
            chosen.target,
            options.episodes,
        )
        for rate in options.rate
        for updates in options.updates
    ]  # fmt: skip
    found = run_jobs(run_try, tries, work=work, description="imitation", unit="policy")
    out = Path("results/studies") / f"imitation-updates-{chosen.name}.json"
    write_json(out, {"tries": found, "made_with": provenance()})
    print(out)


if __name__ == "__main__":
    main()
