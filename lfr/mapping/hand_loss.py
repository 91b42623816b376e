"""Whether the target moves its hand as the source would: what G is held to beside Eq. 4.

    L_hand = || m_X(D_X(mu, s), s) - m_Y(D_Y(mu', s), s) ||^2,   (mu', sigma') = G(k_X, s)

D decodes a skill to the actions that are carried out of it, and m says what motion of the hand, and
which of the gripper, these are (`lfr.skills.hand_motion`). Eq. 5 ties G to the target's priors,
which there are for the common tasks alone; what a skill does to the hand is known wherever the
source would choose it, in the new task too, of which the target has seen nothing.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from lfr.mapping.generator import Generator
from lfr.mapping.mapping_params import MappingParams
from lfr.mapping.states import drawn_states
from lfr.skills.hand_motion import HandJacobian, hand_motion
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import CHUNK, SkillVAE
from lfr.spaces import ROBOT_STATE

SKILLS = 2**16
"""Drawn once, of all the source's tasks together."""


class ArmSkills(NamedTuple):
    """How an arm carries out its skills, and what these do to its hand.

    Attributes:
        jacobian: None where its actions are the hand's motions themselves.
    """

    vae: SkillVAE
    jacobian: HandJacobian | None

    def frozen(self) -> ArmSkills:
        """With a copy of the VAE that learns nothing."""
        return ArmSkills(copy.deepcopy(self.vae).requires_grad_(False), self.jacobian)

    def hand_motion(self, skills: Tensor, states: Tensor, steps: int) -> Tensor:
        """(B, steps, 7) of skills (B, Z) that begin in states (B, S), as they are carried out."""
        actions = self.vae.reconstruct(skills, states, steps).clamp(-1.0, 1.0)
        jacobian = None if self.jacobian is None else self.jacobian(states)
        return hand_motion(actions, states, jacobian)


class SourceTask(NamedTuple):
    """A task that the source knows: its prior, and states (N, D) in which to ask it."""

    prior: SkillPrior
    observations: Tensor


@dataclass(frozen=True)
class HandLoss:
    """L_hand over a fixed set of the source's skills.

    Attributes:
        decoder: the target's, a copy.
        k_x: (N, 2Z), the source's skills.
        states: (N, S), the robot's part of the states in which they begin.
        motions: (N, n, 7), how the source's hand would move in the steps that are carried out.
        jacobians: (N, 6, J), of the target's hand there; None where its actions are its motions.
    """

    decoder: SkillVAE
    k_x: Tensor
    states: Tensor
    motions: Tensor
    jacobians: Tensor | None

    def to(self, device: torch.device) -> HandLoss:
        """The same elsewhere; the decoder is moved in place."""
        # cuDNN differentiates an LSTM in training mode alone; nothing but rounding depends on it
        self.decoder.to(device).train(device.type == "cuda")
        jacobians = None if self.jacobians is None else self.jacobians.to(device)
        k_x, states, motions = (part.to(device) for part in (self.k_x, self.states, self.motions))
        return HandLoss(self.decoder, k_x, states, motions, jacobians)

    def slope(self, index: Tensor, k_y: Tensor) -> Tensor:
        """dL/dk_y (B, 2Z) of the mean over the skills of these numbers (B,), mapped to ``k_y``."""
        states = self.states[index]
        mu = k_y.chunk(2, dim=-1)[0].detach().requires_grad_()
        # unclipped: beyond its bounds an action has no slope that would lead it back
        actions = self.decoder.reconstruct(mu, states, self.motions.shape[1])
        jacobians = None if self.jacobians is None else self.jacobians[index]
        apart = hand_motion(actions, states, jacobians) - self.motions[index]
        (by_mu,) = torch.autograd.grad(apart.square().sum(-1).mean(), mu)
        return torch.cat([by_mu, torch.zeros_like(by_mu)], dim=-1)


@torch.no_grad()
def hand_loss(
    tasks: Sequence[SourceTask],
    source: ArmSkills,
    target: ArmSkills,
    params: MappingParams,
    seed: int,
    count: int = SKILLS,
) -> HandLoss:
    """L_hand over ``count`` skills or a few less, of every task as many.

    A share of them, ``params.hand.recombined``, begins in another skill's state: what the source
    would do there it has not said, but what its actions would be there is known.
    """
    source, target = source.frozen(), target.frozen()
    generator = torch.Generator().manual_seed(seed)
    skills, states = [], []
    for task in tasks:
        drawn = drawn_states(task.prior, task.observations, count // len(tasks), params, generator)
        parts = [torch.cat(task.prior(some), dim=-1) for some in drawn.split(CHUNK)]
        skills.append(torch.cat(parts))
        states.append(drawn[:, : ROBOT_STATE.size])
    k_x, where = torch.cat(skills), torch.cat(states)
    chosen = torch.rand(len(k_x), generator=generator) < params.hand.recombined
    other = torch.randint(len(k_x), (int(chosen.sum()),), generator=generator)
    where[chosen] = where[other]
    motions, jacobians, steps = [], [], min(source.vae.execute, target.vae.execute)
    for k, some in zip(k_x.split(CHUNK), where.split(CHUNK), strict=True):
        motions.append(source.hand_motion(k.chunk(2, dim=-1)[0], some, steps))
        if target.jacobian is not None:
            jacobians.append(target.jacobian(some))
    return HandLoss(
        target.vae, k_x, where, torch.cat(motions), torch.cat(jacobians) if jacobians else None
    )


@torch.no_grad()
def hand_difference(
    task: SourceTask, g: Generator, source: ArmSkills, target: ArmSkills
) -> dict[str, float]:
    """Root-mean-square difference at the hand of the mean skill as either arm does it, and scale.

    Returns:
        hand_difference: in units of a hand's motion, of translation and rotation together.
        hand_motion: the root-mean-square of the source's, in the same units.
    """
    apart = moved = 0.0
    steps = min(source.vae.execute, target.vae.execute)
    for some in task.observations.split(CHUNK):
        mu, log_sigma = task.prior(some)
        wanted = source.hand_motion(mu, some, steps)
        found = target.hand_motion(g.at(mu, log_sigma, some)[0], some, steps)
        apart += float((found - wanted)[..., :6].square().sum())
        moved += float(wanted[..., :6].square().sum())
    count = len(task.observations) * steps * 6
    return {"hand_difference": (apart / count) ** 0.5, "hand_motion": (moved / count) ** 0.5}
