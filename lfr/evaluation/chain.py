"""The chain from the source's prior to the target's skill, link by link: where success is lost.

Every link is zero-shot success on the transfer's new task, over the same held-out starts:

    own_arm       source prior, source decoder, on the source
    identity      source prior, source decoder, on the target: the arms' difference alone
    no_generator  source prior, target decoder, nothing between
    recoded       source prior, its decoded actions through the target's VAE: what that VAE can say;
                  retargeted before where they are other actions
    linear        source prior, the best linear map of G's own pairs, target decoder
    mapped        source prior, G, target decoder: what transfer learning starts from
    retarget      source prior, source decoder, both arms' kinematic models (`lfr.mapping.retarget`)
    oracle        the target's own prior of the new task, with the decoder of all its tasks

Where the two arms' actions are different things, such as motions of their joints, identity has the
target carry them out all the same, joint by joint; elsewhere retargeting would be the identity. The
first and the last are what a prior does on its own arm (`lfr.evaluation.own_arm`), which the skills
stage measures; `lfr.evaluation.records.chain_records` puts the chain together. Of an arm that is
known by its datasets there is no kinematic model, so nothing is retargeted to it.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lfr.environments.simulation import ExternalTarget
from lfr.evaluation.trials import Trial, success_rate, trial_jobs
from lfr.jobs import Job, run_jobs
from lfr.mapping.mapped_policy import MappedFiles
from lfr.mapping.mapping_jobs import MappingJob, fit_mapping
from lfr.mapping.retarget import RetargetFiles
from lfr.policies import PolicySource
from lfr.scenarios import Role, Transfer
from lfr.skills.library import RoleModels, same_actions
from lfr.skills.skill_policy import SkillFiles, UntranslatedFiles


def chain_trials(
    transfer: Transfer,
    skills: Mapping[Role, RoleModels],
    mapping: Path,
    episodes: int,
    external: ExternalTarget | None = None,
) -> dict[str, Trial]:
    """The links of a transfer's chain that lead from one arm to the other.

    Args:
        skills: the transfer's skill models.
        mapping: folder of its G and F.
        external: the target's environment, where it is not simulated here.

    Raises:
        DataError: a skill model is missing or damaged.
        LfrError: one has seen a task that is hidden from its role.
    """
    task, source = transfer.task, skills["source"]
    prior, vae, target_vae = map(str, (source.prior(task), source.vae(), skills["target"].vae()))
    alike = same_actions(skills)
    policies: dict[str, PolicySource] = {
        "identity": SkillFiles(prior, vae) if alike else UntranslatedFiles(prior, vae, target_vae),
        "no_generator": SkillFiles(prior, target_vae),
    }
    modelled = external is None
    if alike:
        policies["recoded"] = SkillFiles(prior, target_vae, encoder=vae)
    elif modelled:
        policies["recoded"] = RetargetFiles(prior, vae, encoder=target_vae)
    policies["linear"] = MappedFiles(prior, str(mapping / "linear"), target_vae)
    policies["mapped"] = MappedFiles(prior, str(mapping / "g"), target_vae)
    if modelled and not alike:
        policies["retarget"] = RetargetFiles(prior, vae)
    return {
        name: Trial(files, transfer.target, task, episodes, external=external)
        for name, files in policies.items()
    }


def train_and_measure(
    spec: MappingJob, trials: Mapping[str, Trial], work: Path, description: str
) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    """Train G and F, and run the links; those that need no G while it is being trained.

    Args:
        trials: as `chain_trials` gives them.

    Returns:
        The report of the mapping, and each link's success.
    """
    mapping = Job(fit_mapping, spec)
    shards = {
        name: trial_jobs(trial, (mapping,) if name in ("linear", "mapped") else ())
        for name, trial in trials.items()
    }
    jobs = [mapping, *itertools.chain(*shards.values())]
    done = run_jobs(jobs, work=work, description=description, unit="part")
    return done[mapping], {name: success_rate(link, done) for name, link in shards.items()}
