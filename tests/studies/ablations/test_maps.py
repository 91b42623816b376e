"""Other phi, where the right one is known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import torch
from torch import Tensor, nn

from lfr.embodiments import embodiment
from lfr.mapping.generator import Generator
from lfr.mapping.hand_loss import SourceTask
from lfr.mapping.mapping_jobs import Material, mapping_job
from lfr.mapping.mapping_training import (
    ActionWindows,
    CommonTask,
    MappingParams,
    Pairs,
    drawn_pairs,
    paired,
    train_mapping,
)
from lfr.scenarios import Scenario, transfers_of
from lfr.skills.library import transfer_models
from lfr.skills.prior import SkillPrior
from lfr.skills.symmetry import SymmetryParams
from lfr.skills.vae import SkillVAE
from lfr.tasks import task
from studies.ablations.maps import MapJob, fitted, map_jobs, map_report, shuffled

Z = 3
NAMES = task("lift").observation.names
STILL = MappingParams(
    condition="none",
    hidden=32, steps=300, batch=64, learning_rate=3e-3, symmetry=SymmetryParams(copies=0),
    posterior_share=0.5,
)  # fmt: skip
SCENARIO = Scenario("s1", ("pick_place", "nut_assembly"), {"panda": "lift", "sawyer": "stack"})


def drawn(*shape: int, seed: int) -> Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed))


def states(count: int, seed: int) -> Tensor:
    return 0.3 * drawn(count, len(NAMES), seed=seed)


def prior(seed: int) -> SkillPrior:
    torch.manual_seed(seed)
    made = SkillPrior(NAMES, Z, hidden=16, layers=2)
    made.normalizer.fit(states(200, 0), NAMES)
    last = made.network[-1]
    assert isinstance(last, nn.Linear)
    with torch.no_grad():
        last.weight[:Z] *= 6.0  # means that differ from state to state
    return made.eval()


@pytest.fixture(scope="module")
def tasks() -> list[CommonTask]:
    return [CommonTask(one, one, states(400, 1)) for one in (prior(1), prior(2))]


@pytest.fixture(scope="module")
def vaes() -> tuple[SkillVAE, SkillVAE]:
    torch.manual_seed(7)
    one = SkillVAE(4, 7, Z, 16).eval()
    return one, one


@pytest.fixture(scope="module")
def windows() -> ActionWindows:
    return ActionWindows(drawn(50, 4, 7, seed=2).clamp(-1, 1), embodiment("panda").action.names)


@pytest.fixture(scope="module")
def pairs(
    tasks: list[CommonTask], vaes: tuple[SkillVAE, SkillVAE], windows: ActionWindows
) -> Pairs:
    return drawn_pairs(tasks, vaes, windows, STILL, seed=0)


@pytest.fixture(scope="module")
def whole(pairs: Pairs) -> Generator:
    """G of Algorithm 1 itself."""
    return train_mapping(pairs, STILL, seed=0)[0]


def test_pairs_are_those_of_algorithm_1(
    tasks: list[CommonTask], vaes: tuple[SkillVAE, SkillVAE], windows: ActionWindows
) -> None:
    """Equal priors and encoders on both sides: a pair is one only if both saw the same row."""
    k_x, k_y, _ = drawn_pairs(tasks, vaes, windows, STILL, seed=0, count=2**13)
    assert k_x.shape == (2**13, 2 * Z)
    assert torch.equal(k_x, k_y)
    unencoded, _, nothing = drawn_pairs(tasks, vaes, None, STILL, seed=0, count=2**13)
    assert len(unencoded) == 2**13
    assert nothing is None


def test_shuffled_pairs_teach_nothing_and_whole_ones_do(
    tasks: list[CommonTask], pairs: Pairs, whole: Generator
) -> None:
    broken = shuffled(pairs, seed=0)
    assert torch.equal(broken.k_x, pairs.k_x)
    torch.testing.assert_close(broken.k_y.sort(0).values, pairs.k_y.sort(0).values)
    nothing_learned = train_mapping(broken, STILL, seed=0)[0]
    for one in tasks:
        held_out = CommonTask(one.prior_x, one.prior_y, states(200, 9))
        learned, nothing = map_report(held_out, whole), map_report(held_out, nothing_learned)
        assert learned["regression_g"] < 0.4 * learned["spread_y"]
        assert nothing["regression_g"] > 0.9 * nothing["spread_y"]


def jobs(folder: Path) -> dict[str, MapJob]:
    (transfer, _) = transfers_of(SCENARIO)
    skills, other = (transfer_models(SCENARIO, transfer, folder / name) for name in ("a", "b"))
    own = mapping_job(SCENARIO, transfer, STILL, 0.1, 0, skills, folder / "mapping")
    return map_jobs(own, other["source"], folder / "variants")


def test_what_each_job_changes(tmp_path: Path) -> None:
    made = jobs(tmp_path)
    assert set(made) == {
        "constant", "shuffled", "between_seeds", "untrained", "no_cycle",
        "only_pick_place", "only_nut_assembly",
    }  # fmt: skip
    assert all(job.mapping.folder == str(tmp_path / "variants" / n) for n, job in made.items())
    assert made["only_nut_assembly"].mapping.transfer.common == ("nut_assembly",)
    assert made["no_cycle"].mapping.params.cycle_weight == 0.0
    changed = {name for name, job in made.items() if job.mapping.params != STILL}
    assert changed == {"no_cycle", "untrained"}
    between = made["between_seeds"]
    assert between.other_skills == replace(
        between.mapping.skills["source"], root=str(tmp_path / "b")
    )


def test_untrained_keeps_the_scales_and_no_cycle_the_pairs(
    tasks: list[CommonTask],
    vaes: tuple[SkillVAE, SkillVAE],
    windows: ActionWindows,
    whole: Generator,
    tmp_path: Path,
) -> None:
    made = jobs(tmp_path)
    new = SourceTask(prior(1), states(9, 3))
    known = Material(dict(zip("ab", tasks, strict=True)), {}, windows, new, new, {}, {}, None)
    untrained = fitted(made["untrained"], known, vaes, seed=0)
    assert torch.equal(untrained.centre_out, whole.centre_out)
    held_out = CommonTask(tasks[0].prior_x, tasks[0].prior_y, states(200, 9))
    assert map_report(held_out, untrained)["regression_g"] > 0.8 * spread(held_out)
    no_cycle = fitted(made["no_cycle"], known, vaes, seed=0)
    assert map_report(held_out, no_cycle)["regression_g"] < 0.4 * spread(held_out)


def spread(one: CommonTask) -> float:
    _, k_y, _ = paired(one, one.observations)
    return float((k_y - k_y.median(0).values).abs().sum(-1).mean())
