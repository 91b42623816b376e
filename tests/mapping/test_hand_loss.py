"""L_hand: its gradient against autograd's, and what it tells G where the regression is silent."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import pytest
import torch

from lfr.mapping.generator import Generator
from lfr.mapping.generator_pair import GeneratorPair
from lfr.mapping.hand_loss import (
    HandLoss,
    SourceTask,
    hand_difference,
    hand_loss,
)
from lfr.mapping.mapping_params import HandLossParams, MappingParams
from lfr.mapping.mapping_training import Pairs, train_mapping
from lfr.skills.condition import GIVEN_NOTHING, Condition
from lfr.skills.hand_motion import hand_motion
from lfr.skills.symmetry import AS_RECORDED
from lfr.spaces import ROBOT_STATE

from .made_up import STEPS, Z, arm, prior, states

PARAMS = MappingParams(
    hidden=64, steps=800, batch=32, learning_rate=3e-3, symmetry=AS_RECORDED, state_noise=0.0,
    hand=HandLossParams(weight=30.0, batch=32, recombined=0.0),
)  # fmt: skip
ARMS = ("panda-joint_position", "ur5e-joint_position", "sawyer")


@pytest.mark.parametrize("target", ARMS)
@pytest.mark.parametrize("conditioned", [False, True])
def test_its_gradient_is_autograds(target: str, conditioned: bool) -> None:
    """Seven joints, six, and actions that are the hand's motion."""
    tasks, arms = (
        [SourceTask(prior(), states(40))],
        (arm("panda-joint_position", 1), arm(target, 2)),
    )
    found = hand_loss(tasks, *arms, PARAMS, seed=0, count=40)
    torch.manual_seed(3)
    seen = Condition(ROBOT_STATE.names, True) if conditioned else GIVEN_NOTHING
    g, f = (Generator(Z, 8, 3, *seen) for _ in range(2))
    for one, ks in ((g, (found.k_x, 2 * found.k_x + 1)), (f, (2 * found.k_x + 1, found.k_x))):
        one.fit_scales(*ks, found.states)
    index = torch.arange(7)
    features = g.features(found.states)[index] if conditioned else None

    k_y = g.translate(found.k_x[index], features)
    mu = k_y[:, :Z]
    where = found.states[index]
    actions = arms[1].vae.reconstruct(mu, where)[:, :STEPS]
    J = None if arms[1].jacobian is None else arms[1].jacobian(where)
    moved = hand_motion(actions, where, J)
    ((moved - found.motions[index]) ** 2).sum(-1).mean().backward()

    pair = GeneratorPair(g, f)
    known = pair.standardised(found.k_x, found.k_x)[0]
    gradient = pair.gradient_of_mapped(known[index], partial(found.slope, index), features)
    pair.networks.vector.copy_(gradient)
    pair.networks.write_back()  # the gradient, read as parameters
    for parameter in g.network.parameters():
        assert parameter.grad is not None
        torch.testing.assert_close(parameter.detach(), parameter.grad, rtol=1e-3, atol=1e-6)
    assert all(not parameter.any() for parameter in f.network.parameters())


def test_g_learns_from_it_what_the_common_tasks_do_not_say() -> None:
    """Pairs of a single skill, beside the source's skills of another task, and a target that is the
    source again: then G has to be the identity.
    """
    source = target = arm("panda-joint_position", 1)
    asked = SourceTask(prior(), states(400))
    pairs = Pairs(6.0 + torch.randn(300, 2 * Z), torch.randn(300, 2 * Z))
    differences = []
    for weight in (0.0, 30.0):
        params = replace(PARAMS, hand=replace(PARAMS.hand, weight=weight))
        compared = hand_loss([asked], source, target, params, seed=0, count=2000)
        g, _ = train_mapping(pairs, params, 0, hand=compared if weight else None)
        held_out = SourceTask(asked.prior, states(100, 9))
        found = hand_difference(held_out, g, source, target)
        differences.append(found["hand_difference"])
        assert found["hand_motion"] > 0.0
    assert differences[1] < 0.4 * differences[0]


def test_a_recombined_skill_is_what_the_source_would_do_there() -> None:
    source, target = arm("panda-joint_position", 1), arm("ur5e-joint_position", 2)
    tasks = [SourceTask(prior(seed), states(50, seed)) for seed in (0, 1)]
    all_of_them = replace(PARAMS, hand=replace(PARAMS.hand, recombined=1.0))
    as_said, moved = (
        hand_loss(tasks, source, target, params, 0, count=80) for params in (PARAMS, all_of_them)
    )
    assert torch.equal(as_said.k_x, moved.k_x)
    assert not torch.equal(as_said.states, moved.states)
    assert torch.isin(moved.states[:, 0], as_said.states[:, 0]).all()
    for one in (as_said, moved):
        k = one.k_x[3:4]
        where = one.states[3:4]
        assert source.jacobian is not None
        actions = torch.stack(source.vae.carry_out(k[:, :Z], where))
        expected = hand_motion(actions, where, source.jacobian(where))
        torch.testing.assert_close(one.motions[3:4], expected, rtol=1e-4, atol=1e-5)


def test_it_is_the_mean_over_the_skills() -> None:
    """A difference quotient of the loss written out."""
    source, target = arm("panda-joint_position", 1), arm("sawyer", 2)
    found = hand_loss([SourceTask(prior(), states(20))], source, target, PARAMS, 0, count=20)
    index, k_y = torch.tensor([4, 7]), torch.randn(2, 2 * Z)

    def loss(one: HandLoss, k: torch.Tensor) -> float:
        total = 0.0
        for row, number in enumerate(index.tolist()):
            where = one.states[number : number + 1]
            actions = target.vae.reconstruct(k[row : row + 1, :Z], where)[:, :STEPS]
            moved = hand_motion(actions, where)
            total += float(((moved - one.motions[number]) ** 2).sum()) / (2 * STEPS)
        return total

    step = torch.zeros_like(k_y)
    step[1, 2] = 1e-2
    with torch.no_grad():
        quotient = (loss(found, k_y + step) - loss(found, k_y - step)) / 2e-2
    slope = found.slope(index, k_y)
    assert float(slope[1, 2]) == pytest.approx(quotient, rel=1e-2, abs=1e-4)
    assert not slope[:, Z:].any()
