"""Training of a skill VAE and of skill priors on windows of demonstrations (Eq. 2 and 3).

Batches are drawn, blurred and moved many steps at a time: on small networks each operation costs
more to call than to carry out.
"""

from __future__ import annotations

import copy
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from lfr.networks.device import CPU
from lfr.networks.optimizer import FlatAdam, annealed, clip_norm, flatten_parameters, trainable
from lfr.skills.augmentation import augment
from lfr.skills.condition import GIVEN_NOTHING, Condition
from lfr.skills.hand_motion import HandJacobian
from lfr.skills.moved_joints import moved_joint_copies
from lfr.skills.prior import SkillPrior
from lfr.skills.prior_ensemble import PriorEnsemble
from lfr.skills.skill_params import PriorParams, VAEParams
from lfr.skills.symmetry import moved_copies
from lfr.skills.vae import SkillVAE, vae_loss

MOST_NORM = 10.0  # of a model's gradient
STEPS_AT_ONCE = 16  # of which the batches are drawn together


def train_vae(
    actions: Tensor,
    names: Sequence[str],
    params: VAEParams,
    seed: int,
    device: torch.device = CPU,
    states: Tensor | None = None,
    condition: Condition = GIVEN_NOTHING,
    jacobian: HandJacobian | None = None,
) -> SkillVAE:
    """A skill VAE of action windows (N, H, A) in [-1, 1], named ``names``, all tasks together.

    Every task counts alike only if its windows do: give it as many as it should weigh.

    Args:
        states: (N, S), where the windows begin, and ``condition``, what the VAE sees of them.
        jacobian: by which errors count at the hand.

    Raises:
        ValueError: states are needed, and there are none.
    """
    if states is None and (jacobian is not None or condition.state_names):
        raise ValueError("a VAE that sees states, or errs at the hand, is trained with states")
    torch.manual_seed(seed)
    generator = torch.Generator().manual_seed(seed)
    sees_a_hand = bool(condition.state_names) and names[-1] == "gripper"
    vae = SkillVAE(
        params.horizon, actions.shape[-1], params.latent_dim, params.hidden, params.execute,
        *condition, params.whole_release and sees_a_hand,
    )  # fmt: skip
    if vae.normalizer is not None and states is not None:
        vae.normalizer.fit(states, vae.state_names)
    vae.to(device)
    jacobian = None if jacobian is None else copy.deepcopy(jacobian).to(device)
    weights = trainable(vae)
    adam = FlatAdam(flatten_parameters(vae), params.learning_rate)
    # cuDNN would have each LSTM's weights by themselves; here they are parts of one vector
    warnings.filterwarnings("ignore", message="RNN module weights are not part")
    batches = _batches(vae, actions, names, params, generator, states, jacobian)
    for step, (batch, features, J) in enumerate(batches):
        loss, _ = vae_loss(vae, batch, params.alpha, features, J)
        gradient = torch.cat([g.reshape(-1) for g in torch.autograd.grad(loss, weights)])
        adam.lr = annealed(params.learning_rate, step, params.steps)
        adam.descend(clip_norm(gradient, MOST_NORM))
    return vae.cpu().eval()


def _batches(
    vae: SkillVAE,
    actions: Tensor,
    names: Sequence[str],
    params: VAEParams,
    generator: torch.Generator,
    states: Tensor | None,
    jacobian: HandJacobian | None,
) -> Iterator[tuple[Tensor, Tensor | None, Tensor | None]]:
    """For each step windows (B, H, A), some of them augmented, and of where they begin what the
    VAE sees, (B, F), and the hand's Jacobian, (B, 6, A - 1); on the device of the VAE.
    """
    augmented = round(params.augment * params.batch)
    device = vae.output.weight.device
    for first in range(0, params.steps, STEPS_AT_ONCE):
        steps = min(STEPS_AT_ONCE, params.steps - first)
        drawn = torch.randint(len(actions), (steps, params.batch), generator=generator)
        batches = actions[drawn]
        if augmented:
            made = augment(batches[:, :augmented].flatten(0, 1), names, generator)
            batches[:, :augmented] = made.unflatten(0, (steps, augmented))
        features, J = [None] * steps, [None] * steps
        if states is not None:
            seen = states[drawn.flatten()].to(device)
            with torch.no_grad():
                if vae.state_names:
                    features = vae.features(seen).unflatten(0, (steps, params.batch))
                if jacobian is not None:
                    J = jacobian(seen).unflatten(0, (steps, params.batch))
        yield from zip(batches.to(device), features, J, strict=True)


@dataclass(frozen=True)
class PriorMaterial:
    """What the skill prior of one arm and task is trained on.

    Attributes:
        observations: (N, D), where the windows start, in the units of the layout ``names``.
        actions: (N, H, A), the windows, whose dimensions are called ``action_names``.
        seed: of this prior's training.
        turned: whether the prior sees the scene in the frame of the hand's azimuth.
        jacobian: of the hand, by which moved copies of joint motions are made if they are asked
            for.
    """

    observations: Tensor
    actions: Tensor
    names: Sequence[str]
    action_names: Sequence[str]
    seed: int
    turned: bool = False
    jacobian: HandJacobian | None = None


def train_priors(
    vae: SkillVAE,
    materials: Iterable[PriorMaterial],
    params: PriorParams,
    device: torch.device = CPU,
) -> list[SkillPrior]:
    """A skill prior for each material, for a trained VAE; all of them trained as one network.

    Each has its own seed and draws from it alone, so that it is, up to rounding, the prior that it
    would be by itself. Materials may be read as they are asked for: of each, its states and their
    posteriors are kept, and no windows.
    """
    encoder = copy.deepcopy(vae).to(device)
    learners = [_PriorLearner.start(encoder, material, params) for material in materials]
    ensemble = PriorEnsemble([learner.prior for learner in learners], device)
    networks = ensemble.networks
    adam = FlatAdam(networks.vector, params.learning_rate, weight_decay=params.weight_decay)
    for first in range(0, params.steps, STEPS_AT_ONCE):
        steps = min(STEPS_AT_ONCE, params.steps - first)
        drawn = [learner.draw(steps, params) for learner in learners]
        inputs = networks.together([inputs for inputs, _, _ in drawn]).to(
            device
        )  # (E, steps, B, in)
        mu, log_sigma = (torch.stack([one[i] for one in drawn]).to(device) for i in (1, 2))
        for k in range(steps):
            adam.lr = annealed(params.learning_rate, first + k, params.steps)
            gradient = ensemble.gradient(inputs[:, k], mu[:, k], log_sigma[:, k])
            adam.descend(networks.clipped(gradient, MOST_NORM))
    networks.write_back()
    return [learner.prior.eval() for learner in learners]


@dataclass(frozen=True)
class _PriorLearner:
    """One prior, its windows and moved copies of them, and what the VAE makes of these."""

    prior: SkillPrior
    observations: Tensor  # (N, D)
    mu: Tensor  # (N, Z)
    log_sigma: Tensor  # (N, Z)
    generator: torch.Generator

    @classmethod
    def start(cls, vae: SkillVAE, material: PriorMaterial, params: PriorParams) -> _PriorLearner:
        torch.manual_seed(material.seed)
        generator = torch.Generator().manual_seed(material.seed)
        prior = SkillPrior(
            material.names, vae.latent_dim, params.hidden, params.layers, material.turned
        )
        windows = material.observations, material.actions
        if params.joint_copies and material.jacobian is not None:
            observations, actions = moved_joint_copies(
                *windows, tuple(material.names), params.symmetry, material.jacobian, generator
            )
        else:
            observations, actions = moved_copies(
                *windows, material.names, material.action_names, params.symmetry, generator
            )
        prior.normalizer.fit(observations, material.names)
        return cls(prior, observations, *vae.encode_all(actions, observations), generator)

    @torch.no_grad()
    def draw(self, steps: int, params: PriorParams) -> tuple[Tensor, Tensor, Tensor]:
        """What the prior sees and shall predict in so many steps: (steps, B, in), (steps, B, Z)."""
        count = len(self.observations)
        drawn = torch.randint(count, (steps * params.batch,), generator=self.generator)
        seen = self.observations[drawn]
        blur = params.input_noise * self.prior.normalizer.noise_scale()
        seen = seen + blur * torch.randn(seen.shape, generator=self.generator)
        parts = self.prior.normalizer(seen), self.mu[drawn], self.log_sigma[drawn]
        inputs, mu, log_sigma = (part.unflatten(0, (steps, params.batch)) for part in parts)
        return inputs, mu, log_sigma
