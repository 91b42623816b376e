"""Untrained arms whose skills do something, and a source that asks for them."""

from __future__ import annotations

import torch

from lfr.embodiments import embodiment
from lfr.mapping.hand_loss import ArmSkills
from lfr.skills.condition import POSE_NAMES
from lfr.skills.hand_motion import HandJacobian
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import SkillVAE
from lfr.tasks import task

Z, H, STEPS = 3, 4, 2
NAMES = task("lift").observation.names


def states(count: int, seed: int = 0) -> torch.Tensor:
    generator = torch.Generator().manual_seed(seed)
    seen = 0.3 * torch.randn(count, len(NAMES), generator=generator)
    seen[:, 0] += 1.0  # in front of the base
    return seen


def prior(seed: int = 0) -> SkillPrior:
    torch.manual_seed(seed)
    made = SkillPrior(NAMES, Z, hidden=16, layers=2)
    made.normalizer.fit(states(200), NAMES)
    with torch.no_grad():
        made.network[-1].weight[:Z] *= 6.0  # type: ignore[index,operator]  # means that differ
    return made.eval()


def arm(name: str, seed: int) -> ArmSkills:
    torch.manual_seed(seed)
    actions = embodiment(name).action.names
    vae = SkillVAE(H, len(actions), Z, 8, STEPS, state_names=POSE_NAMES, turned=True).eval()
    with torch.no_grad():
        vae.initial.weight *= 4.0
        vae.output.weight *= 4.0  # skills that differ in what they do
    assert vae.normalizer is not None
    vae.normalizer.fit(states(200)[:, :9], POSE_NAMES)
    if not name.endswith("joint_position"):
        return ArmSkills(vae, None)
    jacobian = HandJacobian(len(actions) - 1, 8).eval()
    assert jacobian.normalizer is not None
    jacobian.normalizer.fit(states(200)[:, :9], POSE_NAMES)
    return ArmSkills(vae, jacobian)
