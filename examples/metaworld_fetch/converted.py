"""The source's policy on Fetch, its actions brought into Fetch's frame, units and signs by hand.

What a user writes who knows both arms: Sawyer's x is against Fetch's y, its y is along Fetch's x;
an action of 1 is 1 cm in 1/80 s, 0.64 of Fetch's 5 cm in 1/25 s; the gripper is turned round.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from lfr.artifacts import write_json
from lfr.columns import ActionPart
from lfr.environments.simulation import external_target
from lfr.evaluation.protocol import EvaluateParams
from lfr.evaluation.trials import Trial, success_rates
from lfr.external import external_arms
from lfr.params import read_section
from lfr.scenarios import scenario, transfer
from lfr.skills.library import pipeline_models
from lfr.skills.saved_models import load_prior
from lfr.skills.skill_policy import UntranslatedFiles

SPEED = 0.01 * 80 / (0.05 * 25)
IN_SAWYERS_TERMS = ActionPart(  # dims of Fetch's action; what -1 and 1 of Sawyer's are there
    dims=(1, 0, 2, 3), names=("dx", "dy", "dz", "gripper"),
    low=(SPEED, -SPEED, -SPEED, 1.0), high=(-SPEED, SPEED, SPEED, -1.0),
)  # fmt: skip


def main() -> None:
    """Write results/converted.json: success from the held-out starts."""
    chosen = transfer("pick-fetch-pick_place")
    known = scenario(chosen.scenario)
    arms = external_arms(known.robots)
    skills = pipeline_models(known, chosen, arms)
    source = skills["source"]
    names = load_prior(source.prior(chosen.task)).layout_names
    fetch = replace(arms[chosen.target], action=IN_SAWYERS_TERMS)
    target = external_target(chosen.target, fetch, chosen.task, chosen.common, names)
    policy = UntranslatedFiles(
        str(source.prior(chosen.task)), str(source.vae()), str(skills["target"].vae())
    )
    episodes = read_section(EvaluateParams, "evaluate").episodes
    trial = Trial(policy, chosen.target, chosen.task, episodes, "environment", external=target)
    found = success_rates({"converted": trial}, Path("work/converted"), "identity, converted")
    write_json(Path("results/converted.json"), found["converted"])


if __name__ == "__main__":
    main()
