"""Algorithm 1 where the right mapping is known: two copies of one latent space, one rotated."""

from __future__ import annotations

import copy
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from torch import nn

from lfr.embodiments import embodiment
from lfr.errors import ParameterError
from lfr.mapping.closed_form import linear
from lfr.mapping.generator import Generator
from lfr.mapping.map_quality import common_report, decoded_difference, new_task_report
from lfr.mapping.mapping_jobs import mapping_job
from lfr.mapping.mapping_training import (
    GIVEN_NOTHING,
    ActionWindows,
    CommonTask,
    Condition,
    MappingParams,
    Pairs,
    condition_of,
    drawn_pairs,
    paired,
    train_mapping,
)
from lfr.scenarios import Scenario, transfers_of
from lfr.skills.library import transfer_models
from lfr.skills.prior import SkillPrior
from lfr.skills.symmetry import SymmetryParams
from lfr.skills.vae import SkillVAE
from lfr.spaces import ROBOT_STATE
from lfr.tasks import task

Z = 3
NAMES = task("lift").observation.names
PARAMS = MappingParams(
    condition="none",
    hidden=64,
    steps=600,
    batch=64,
    learning_rate=3e-3,
    symmetry=SymmetryParams(copies=0),
    posterior_share=0.0,
)
ROTATION = torch.linalg.qr(torch.randn(Z, Z, generator=torch.Generator().manual_seed(4)))[0]


def states(count: int, seed: int) -> torch.Tensor:
    return 0.3 * torch.randn(count, len(NAMES), generator=torch.Generator().manual_seed(seed))


def prior(seed: int) -> SkillPrior:
    torch.manual_seed(seed)
    made = SkillPrior(NAMES, Z, hidden=16, layers=2)
    made.normalizer.fit(states(200, 0), NAMES)
    last = made.network[-1]
    assert isinstance(last, nn.Linear)
    with torch.no_grad():
        last.weight[:Z] *= 6.0  # means that differ from state to state
        last.weight[Z:] *= 0.1
    return made.eval()


def rotated(one: SkillPrior) -> SkillPrior:
    """The same distributions in a latent space turned by ROTATION (the spreads are near 1)."""
    other = copy.deepcopy(one)
    last = other.network[-1]
    assert isinstance(last, nn.Linear)
    with torch.no_grad():
        last.weight[:Z] = ROTATION @ last.weight[:Z]
        last.bias[:Z] = ROTATION @ last.bias[:Z]
    return other


@pytest.fixture(scope="module")
def learned() -> tuple[list[CommonTask], Generator, Generator]:
    tasks = [CommonTask(one, rotated(one), states(400, 1)) for one in (prior(1), prior(2))]
    vaes = SkillVAE(4, 7, Z, 8), SkillVAE(4, 7, Z, 8)
    pairs = drawn_pairs(tasks, vaes, None, PARAMS, seed=0, count=2**14)
    g, f = train_mapping(pairs, PARAMS, seed=0)
    return tasks, g, f


def test_the_rotation_is_found(learned: tuple[list[CommonTask], Generator, Generator]) -> None:
    tasks, g, f = learned
    for one in tasks:
        k_x, _, _ = paired(one, states(200, 9))  # states that nothing was trained on
        mu, log_sigma = k_x.chunk(2, dim=-1)
        there, _ = g(mu, log_sigma)
        expected = mu @ ROTATION.T
        assert (there - expected).norm(dim=-1).mean() < 0.15 * expected.norm(dim=-1).mean()
        back, _ = f(*g(mu, log_sigma))
        assert (back - mu).norm(dim=-1).mean() < 0.15 * mu.norm(dim=-1).mean()


def test_the_report_tells_a_found_mapping_from_none(
    learned: tuple[list[CommonTask], Generator, Generator],
) -> None:
    tasks, g, f = learned
    held_out = CommonTask(tasks[0].prior_x, tasks[0].prior_y, states(100, 8))
    found = common_report(held_out, g, f)
    assert found["regression_g"] < 0.3 * found["spread_y"]
    assert found["regression_f"] < 0.3 * found["spread_x"]
    assert found["cycle_x"] < 0.3 * found["spread_x"]
    k_x, k_y, _ = paired(held_out, held_out.observations)
    expected = (g.translate(k_x) - k_y).abs().sum(-1).mean()
    assert found["regression_g"] == pytest.approx(expected.item(), rel=1e-5)
    new = new_task_report(tasks[0].prior_x, states(100, 8), g, f)
    assert new["cycle_x"] == pytest.approx(found["cycle_x"], rel=1e-6)


def test_decoders_of_one_space_agree_through_the_mapping(
    learned: tuple[list[CommonTask], Generator, Generator],
) -> None:
    """A target whose decoder undoes the rotation first does what the source does."""

    class Turned(SkillVAE):
        def decode(self, z: torch.Tensor, observations: torch.Tensor | None = None) -> torch.Tensor:
            return super().decode(z @ ROTATION, observations)

    tasks, g, _ = learned
    torch.manual_seed(3)
    source, target = SkillVAE(4, 7, Z, 16), Turned(4, 7, Z, 16)
    target.load_state_dict(source.state_dict())
    mapped = decoded_difference(tasks[0].prior_x, states(100, 7), g, source, target)
    class_blind = decoded_difference(tasks[0].prior_x, states(100, 7), g, source, source)
    assert mapped.shape == (7,)
    assert mapped.sum() < 0.3 * class_blind.sum()


@pytest.mark.parametrize("posterior_share", [0.0, 0.5])
def test_the_same_seed_gives_the_same_tensors(posterior_share: float) -> None:
    params = MappingParams(hidden=8, steps=3, batch=8, posterior_share=posterior_share)
    tasks = [CommonTask(prior(1), prior(2), states(20, 1))]
    vaes = SkillVAE(4, 7, Z, 8), SkillVAE(4, 7, Z, 8)
    windows = ActionWindows(torch.rand(5, 4, 7) - 0.5, embodiment("panda").action.names)

    def trained(seed: int) -> torch.Tensor:
        pairs = drawn_pairs(tasks, vaes, windows, params, seed, count=64)
        return train_mapping(pairs, params, seed)[0].translate(torch.ones(1, 2 * Z))

    assert torch.equal(trained(1), trained(1))
    assert not torch.equal(trained(1), trained(2))


def test_g_that_sees_the_state_finds_what_g_of_k_alone_cannot() -> None:
    """A target whose skills are the source's, and beside them where the hand is."""
    layout = task("lift").observation.names
    generator = torch.Generator().manual_seed(2)
    drawn = 0.3 * torch.randn(600, len(layout), generator=generator)
    k_x = torch.randn(600, 2 * Z, generator=generator)
    k_y = torch.cat([k_x[:, :Z] + 5.0 * drawn[:, :1], k_x[:, Z:]], dim=-1)
    errors: dict[Condition, list[float]] = {}
    for condition in (GIVEN_NOTHING, Condition(ROBOT_STATE.names)):
        states = drawn[:, : ROBOT_STATE.size] if condition.state_names else None
        pairs = Pairs(k_x, k_y, states)
        for made in (train_mapping(pairs, PARAMS, 0, condition)[0], linear(pairs, condition)):
            seen = None if states is None else made.features(states)
            error = float((made.translate(k_x, seen) - k_y).detach().abs().mean())
            errors.setdefault(condition, []).append(error)
    blind, seeing = errors.values()
    assert seeing[0] < 0.5 * blind[0]
    assert seeing[1] < 1e-4 < blind[1]


def test_the_state_is_that_of_the_pair_and_windows_have_any() -> None:
    layout = task("lift").observation.names
    generator = torch.Generator().manual_seed(2)
    seen = 0.3 * torch.randn(50, len(layout), generator=generator)
    made = []
    for seed in (1, 2):
        torch.manual_seed(seed)
        made.append(SkillPrior(layout, Z, 16, 2, turned=True))
    common = CommonTask(made[0].eval(), made[1].eval(), seen)
    params = replace(PARAMS, condition="state", posterior_share=0.5, state_noise=0.0)
    windows = ActionWindows(torch.rand(5, 4, 7) - 0.5, embodiment("panda").action.names)
    vaes = SkillVAE(4, 7, Z, 8), SkillVAE(4, 7, Z, 8)
    pairs = drawn_pairs([common], vaes, windows, params, seed=0, count=64)
    assert pairs.states is not None
    assert pairs.states.shape == (64, ROBOT_STATE.size)
    rows = {tuple(row) for row in seen[:, : ROBOT_STATE.size].tolist()}
    assert {tuple(row) for row in pairs.states.tolist()} <= rows
    for state, k_x in zip(pairs.states[:32], pairs.k_x[:32], strict=True):  # the priors' own
        at = int((seen[:, : ROBOT_STATE.size] == state).all(1).nonzero()[0])
        torch.testing.assert_close(k_x, torch.cat(made[0](seen[at : at + 1]), -1)[0])
    begun = windows._replace(states=torch.rand(5, ROBOT_STATE.size))
    pairs = drawn_pairs([common], vaes, begun, params, seed=0, count=64)
    assert pairs.states is not None
    rows = {tuple(row) for row in begun.states.tolist()}
    assert {tuple(row) for row in pairs.states[32:].tolist()} <= rows
    assert condition_of([common], params) == Condition(ROBOT_STATE.names, turned=True)
    assert condition_of([common], PARAMS) == GIVEN_NOTHING
    made = [SkillPrior(layout[1:], Z, 8, 1) for _ in range(2)]
    blind = CommonTask(made[0], made[1], seen[:, 1:])
    with pytest.raises(ParameterError, match="do not begin with the hand's state"):
        condition_of([blind], params)


@pytest.mark.parametrize(
    ("arms", "copies", "shifted"),
    [
        (("panda", "sawyer"), True, True),
        (("panda", "ur5e-joint_position"), True, False),  # turns alone: one arm's skills turn
        (("panda-joint_position", "ur5e-joint_position"), False, False),  # the priors' frame
    ],
)
def test_states_are_moved_as_both_arms_allow(
    arms: tuple[str, str], copies: bool, shifted: bool, tmp_path: Path
) -> None:
    scenario = Scenario("s", ("pick_place",), {arms[1]: "lift"}, arms)
    (transfer,) = transfers_of(scenario)
    skills = transfer_models(scenario, transfer, tmp_path)
    job = mapping_job(scenario, transfer, MappingParams(), 0.1, 0, skills, tmp_path)
    moved = job.params.symmetry
    assert (moved.copies > 0, moved.shift > 0.0, moved.mirror) == (copies, shifted, shifted)
    assert (moved.turn > 0.0) == copies
