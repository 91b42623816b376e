"""Soft actor-critic from scratch on the target, without skills (Haarnoja et al. 2018).

The same loop and learner as every method: z is one control step's action, and the prior that the
policy is held near is the uniform distribution over actions, which makes of Eq. 9 SAC's entropy.
Parameters that count skills then count control steps; ``min_sigma`` is not for this policy.
"""

from __future__ import annotations

from lfr.transfer.actor import OneAction, SkillActor
from lfr.transfer.distribution import SQUASHED
from lfr.transfer.extended_policy import IdentityMap, MappedPolicy, StandardNormal
from lfr.transfer.methods.initialization import Initialization, TrainedModels, new_pi
from lfr.transfer.transfer_params import TransferParams


def sac(models: TrainedModels, params: TransferParams) -> Initialization:
    """A new policy with networks as large as the critics'.

    Like every method's, its inputs come in the units of the source's demonstrations: of the other
    arm SAC learns nothing but these.
    """
    reference = models.source_prior()
    actions = models.target_vae().action_dim
    hidden = params.critic_hidden
    pi = new_pi(reference, actions, hidden[0], len(hidden))
    actor = SkillActor(
        policy=MappedPolicy(pi, IdentityMap()),
        prior=MappedPolicy(StandardNormal(actions), IdentityMap()),
        decoder=OneAction(actions),
        distribution=SQUASHED,
    )
    return Initialization(actor, reference.normalizer, reference.layout_names)
