"""Algorithm 1: G and F trained on the skill distributions that both arms predict for a state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import torch
from torch import Tensor

from lfr.errors import ParameterError
from lfr.mapping.generator import Generator
from lfr.mapping.generator_pair import GeneratorPair
from lfr.mapping.hand_loss import HandLoss
from lfr.mapping.mapping_params import MappingParams
from lfr.mapping.states import drawn_states
from lfr.networks.device import device_named
from lfr.networks.optimizer import FlatAdam, annealed, clip_norm
from lfr.skills.augmentation import augment
from lfr.skills.condition import GIVEN_NOTHING, Condition
from lfr.skills.prior import SkillPrior
from lfr.skills.vae import CHUNK, SkillVAE
from lfr.spaces import ROBOT_STATE

MOST_NORM = 50.0  # of the gradient
PAIRS = 2**17
"""Made once and drawn from again and again: far more than the numbers that G and F learn."""


@dataclass(frozen=True)
class CommonTask:
    """One task that both arms know: their priors for it and the states to compare them in.

    Attributes:
        prior_x: the source's prior.
        prior_y: the target's prior.
        observations: (N, D), states of both arms' demonstrations.
    """

    prior_x: SkillPrior
    prior_y: SkillPrior
    observations: Tensor


class ActionWindows(NamedTuple):
    """Actions (N, H, A) in [-1, 1], their dimensions called ``names``, and where they begin.

    Attributes:
        states: (N, S), the robot's part of the states.
    """

    actions: Tensor
    names: tuple[str, ...]
    states: Tensor | None = None


class Pairs(NamedTuple):
    """Skill distributions of the two arms for the same states or actions, (N, 2Z) each.

    Attributes:
        states: the robot's part of the states, (N, S); None where nobody asks for it.
    """

    k_x: Tensor
    k_y: Tensor
    states: Tensor | None = None


def condition_of(tasks: Sequence[CommonTask], params: MappingParams) -> Condition:
    """What G and F see of the states of these tasks.

    In the frame of the hand's azimuth where neither arm's skills depend on it.

    Raises:
        ParameterError: the hand's state is to be seen, and a task's layout does not begin with it.
    """
    if params.condition == "none":
        return GIVEN_NOTHING
    names = ROBOT_STATE.names
    for task in tasks:
        if task.prior_x.layout_names[: len(names)] != names:
            raise ParameterError(
                "mapping.condition: state: these observations do not begin with the hand's state; "
                "choose none"
            )
    turned = all(task.prior_x.turned and task.prior_y.turned for task in tasks)
    return Condition(names, turned)


@torch.no_grad()
def paired(task: CommonTask, observations: Tensor) -> Pairs:
    """k_x and k_y (B, 2Z): what either arm would do in the same states (lines 5 to 7)."""
    k_x, k_y = (
        torch.cat([torch.cat(prior(some), dim=-1) for some in observations.split(CHUNK)])
        for prior in (task.prior_x, task.prior_y)
    )
    return Pairs(k_x, k_y)


def train_mapping(
    pairs: Pairs,
    params: MappingParams,
    seed: int,
    condition: Condition = GIVEN_NOTHING,
    hand: HandLoss | None = None,
) -> tuple[Generator, Generator]:
    """G: X -> Y and F: Y -> X, by Algorithm 1.

    Algorithm 1 draws a common task and a state in each iteration, predicts both arms'
    distributions, maps them and descends on Eq. 4. Lines 9 and 10 map one way only, depending on
    whose state it is; here every pair trains both ways, which are the same two terms of Eq. 5.

    Args:
        hand: beside Eq. 4, what G is held to, with the weight that the parameters give it.
    """
    torch.manual_seed(seed)
    generator = torch.Generator().manual_seed(seed)
    latent_dim = pairs.k_x.shape[1] // 2
    g, f = (Generator(latent_dim, params.hidden, params.layers, *condition) for _ in range(2))
    g.fit_scales(pairs.k_x, pairs.k_y, pairs.states)
    f.fit_scales(pairs.k_y, pairs.k_x, pairs.states)
    pair = GeneratorPair(g, f, device_named(params.device))
    known, networks = pair.standardised(pairs.k_x, pairs.k_y), pair.networks
    seen = None if pairs.states is None else g.features(pairs.states).to(known.device)
    if hand is not None:
        hand = hand.to(known.device)
        skills = pair.standardised(hand.k_x, hand.k_x)[0]
        where = None if seen is None else g.features(hand.states.cpu()).to(known.device)
    adam = FlatAdam(networks.vector, params.learning_rate)
    for step in range(params.steps):
        index = torch.randint(len(pairs.k_x), (params.batch,), generator=generator)
        index = index.to(known.device)
        features = None if seen is None else seen[index]
        gradient = pair.gradient(known[:, index], params.cycle_weight, features)
        if hand is not None:
            gradient = gradient.clone()
            drawn = torch.randint(len(skills), (params.hand.batch,), generator=generator)
            at_hand = pair.gradient_of_mapped(
                skills[drawn], partial(hand.slope, drawn), None if where is None else where[drawn]
            )
            gradient.add_(at_hand, alpha=params.hand.weight)
        adam.lr = annealed(params.learning_rate, step, params.steps)
        adam.descend(clip_norm(gradient, MOST_NORM))
    networks.write_back()
    return g.eval(), f.eval()


def drawn_pairs(
    tasks: Sequence[CommonTask],
    encoders: tuple[SkillVAE, SkillVAE],
    windows: ActionWindows | None,
    params: MappingParams,
    seed: int,
    count: int = PAIRS,
) -> Pairs:
    """What G and F learn from: ``count`` pairs, or a few less.

    Both arms' predictions at moved, blurred states, of every task as many, and the share of them
    that the parameters say both encoders' posteriors of the same augmented windows.

    Args:
        tasks: the common tasks.
        encoders: the source's and the target's skill VAE.
        windows: of the common tasks by both arms, used if ``posterior_share`` > 0; None else, as
            where the two arms' actions are different things.
    """
    generator = torch.Generator().manual_seed(seed)
    posteriors = 0 if windows is None else round(params.posterior_share * count)
    per_task = (count - posteriors) // len(tasks)
    pairs = [_predictions(task, per_task, params, generator) for task in tasks]
    if windows is not None and posteriors:
        pairs.append(_posteriors(encoders, windows, posteriors, generator))
    k_x, k_y = torch.cat([pair.k_x for pair in pairs]), torch.cat([pair.k_y for pair in pairs])
    if params.condition == "none":
        return Pairs(k_x, k_y)
    states = torch.cat([pair.states for pair in pairs if pair.states is not None])
    if missing := len(k_x) - len(states):  # windows of which it is not said where they begin
        drawn = torch.randint(len(states), (missing,), generator=generator)
        states = torch.cat([states, states[drawn]])
    return Pairs(k_x, k_y, states)


def _predictions(
    task: CommonTask, count: int, params: MappingParams, generator: torch.Generator
) -> Pairs:
    """Pairs at ``count`` states drawn from the task's and their moved copies, blurred."""
    states = drawn_states(task.prior_x, task.observations, count, params, generator)
    return paired(task, states)._replace(states=states[:, : ROBOT_STATE.size])


@torch.no_grad()
def _posteriors(
    encoders: tuple[SkillVAE, SkillVAE],
    windows: ActionWindows,
    count: int,
    generator: torch.Generator,
) -> Pairs:
    """What both encoders make of the same, augmented windows: pairs beyond the common tasks."""
    index = torch.randint(len(windows.actions), (count,), generator=generator)
    actions = augment(windows.actions[index], windows.names, generator)
    states = None if windows.states is None else windows.states[index]
    k_x, k_y = (torch.cat(encoder.encode_all(actions, states), dim=-1) for encoder in encoders)
    return Pairs(k_x, k_y, states)
