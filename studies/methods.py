"""The baselines beside the library's own methods: SPiRL, and retargeting that learns on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from lfr.embodiments import embodiment
from lfr.mapping.retarget import Retargeting, RetargetPolicy
from lfr.policies import Policy
from lfr.sim.kinematics import kinematics
from lfr.transfer.extended_policy import IdentityMap
from lfr.transfer.methods import METHODS, Method
from lfr.transfer.methods.initialization import Initialization, TrainedModels, initialize_from
from lfr.transfer.model import LearnedFiles
from lfr.transfer.network_kinds import register
from lfr.transfer.transfer_params import TransferParams
from studies.spirl.other_task import OTHER_TASK, load_other_task
from studies.spirl.residual_prior import RESIDUAL_PRIOR, residual_prior


def register_networks() -> None:
    """Make the baselines' networks known, so that policies with them can be saved and loaded."""
    register(OTHER_TASK, RESIDUAL_PRIOR)


def methods(spirl_prior: Path) -> Mapping[str, Method]:
    """The library's methods and the baselines', whose networks are known from here on.

    Args:
        spirl_prior: folder of the prior that `studies.spirl.any_task` trains; read by SPiRL alone.
    """
    register_networks()
    return {**METHODS, "spirl": partial(spirl, spirl_prior), "retarget": retarget}


def spirl(spirl_prior: Path, models: TrainedModels, params: TransferParams) -> Initialization:
    """SPiRL (Pertsch et al. 2021) on the target alone, from its own prior of its common tasks.

    Nothing comes from the other arm but the units of the critics' inputs, which are the same for
    every method. The prior knows nothing of a goal; the policy that begins with it sees everything.
    """
    prior = load_other_task(spirl_prior)
    reference, vae = models.source_prior(), models.target_vae()
    pi = residual_prior(prior, reference)
    return initialize_from(prior, IdentityMap(), vae, params, reference, pi)


def retarget(models: TrainedModels, params: TransferParams) -> Initialization:
    """The source's prior and decoder, whose actions `studies.retargeted` carries out."""
    prior = models.source_prior()
    return initialize_from(prior, IdentityMap(), models.source_vae(), params, prior)


@dataclass(frozen=True)
class BaselineFiles:
    """The folder of a policy that one of these methods has learned.

    Attributes:
        source: the embodiment whose actions it speaks in, if they are retargeted.
    """

    policy: str
    source: str | None = None

    def load(self, robot: str) -> Policy:
        """Raises DataError where the folder holds no policy of this robot, or a damaged one."""
        register_networks()
        policy = LearnedFiles(self.policy).load(robot)
        if self.source is None:
            return policy
        return RetargetPolicy(policy, Retargeting(kinematics(self.source), embodiment(robot)))
