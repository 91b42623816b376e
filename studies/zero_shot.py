"""Zero-shot success of everything that could stand in the chain's places, on held-out starts.

Besides the policies of the chain (`lfr.evaluation.chain`):

    oracle_decoder  source prior, its decoded actions through the oracle's VAE: is it the decoder?
    shared_vae      source prior and decoder of one VAE of both arms
    no_cycle, shuffled, untrained, constant, only_<task>
                    source prior, another phi, target decoder (`studies.ablations.maps`)
    between_seeds   source prior, phi to another VAE of the source, its decoder, on the source
    wrong_task      source prior of a common task, G, target decoder
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from lfr.evaluation.chain import chain_trials
from lfr.evaluation.trials import Trial
from lfr.mapping.mapped_policy import MappedFiles
from lfr.mapping.retarget import RetargetFiles
from lfr.mapping.saved_generators import load_generator
from lfr.policies import Pinned
from lfr.scenarios import Role, Transfer
from lfr.skills.library import RoleModels, same_actions
from lfr.skills.saved_models import check_actions, load_vae
from lfr.skills.skill_policy import SkillFiles, SkillPolicy, UntranslatedFiles
from studies.ablations.other_task import load_other_task

PHI = ("no_cycle", "shuffled", "untrained", "constant")


@dataclass(frozen=True)
class WrongTaskFiles:
    """The folders of an `OtherTaskPrior`, of G, and of the VAE that acts."""

    other_task_prior: str
    generator: str
    decoder: str

    def load(self, robot: str) -> SkillPolicy:
        """Raises DataError where a folder holds no such model, a damaged one or other actions."""
        check_actions(Path(self.decoder), robot)
        prior = load_other_task(Path(self.other_task_prior))
        g = load_generator(Path(self.generator))
        return SkillPolicy(prior, g.at, load_vae(Path(self.decoder)))


Files = SkillFiles | MappedFiles | WrongTaskFiles


def model_trials(
    transfer: Transfer, skills: Mapping[Role, RoleModels], mapping: Path, episodes: int
) -> dict[str, Trial]:
    """The policies that need nothing but a repetition's skill models and mapping."""
    task = transfer.task
    prior, vae = str(skills["source"].prior(task)), str(skills["source"].vae())
    policies: dict[str, Files] = {}
    if transfer.oracle:
        oracle = str(skills["oracle"].vae())
        policies["oracle"] = SkillFiles(str(skills["oracle"].prior(task)), oracle)
        if same_actions(skills):
            policies["oracle_decoder"] = SkillFiles(prior, oracle, encoder=vae)
    own = Trial(Pinned.of(SkillFiles(prior, vae)), transfer.source, task, episodes)
    chain = chain_trials(transfer, skills, mapping, episodes)
    return {
        "own_arm": own,
        **{name: _known(trial) for name, trial in chain.items()},
        **_on_target(transfer, policies, episodes),
    }


def variant_trials(
    transfer: Transfer,
    skills: Mapping[Role, RoleModels],
    mapping: Path,
    other: RoleModels,
    variants: Path,
    episodes: int,
) -> dict[str, Trial]:
    """The policies that need a repetition's variants.

    Args:
        skills, mapping: the repetition's.
        other: the source's skill models of the repetition that `studies.ablations.between_seeds`
            maps onto.
        variants: folder of the repetition's variants, by name.
    """
    task = transfer.task
    prior, target = str(skills["source"].prior(task)), str(skills["target"].vae())
    phi = [*PHI, *(f"only_{common}" for common in transfer.common)]
    shared, wrong = variants / "shared_vae", str(variants / "wrong_task" / "prior")
    policies: dict[str, Files] = {
        "shared_vae": SkillFiles(str(shared / "prior"), str(shared / "vae")),
        **{name: MappedFiles(prior, str(variants / name / "g"), target) for name in phi},
        "wrong_task": WrongTaskFiles(wrong, str(mapping / "g"), target),
    }
    between = MappedFiles(prior, str(variants / "between_seeds" / "g"), str(other.vae()))
    return {
        **_on_target(transfer, policies, episodes),
        "between_seeds": Trial(Pinned.of(between), transfer.source, task, episodes),
    }


def _on_target(transfer: Transfer, policies: dict[str, Files], episodes: int) -> dict[str, Trial]:
    return {
        name: Trial(Pinned.of(files), transfer.target, transfer.task, episodes)
        for name, files in policies.items()
    }


def _known(trial: Trial) -> Trial:
    assert isinstance(trial.policy, SkillFiles | MappedFiles | UntranslatedFiles | RetargetFiles)
    return replace(trial, policy=Pinned.of(trial.policy))
