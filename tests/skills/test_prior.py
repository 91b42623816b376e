"""The skill prior: normalisation with floors, saving, layout errors."""

import math
from pathlib import Path

import pytest
import torch

from lfr.embodiments import embodiment
from lfr.errors import DataError
from lfr.skills.normalizer import TILT_SCALE
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import (
    Seen,
    load_prior,
    load_seen,
    load_vae,
    save_prior,
    save_vae,
)
from lfr.skills.symmetry import SceneMotion, SymmetryParams, move
from lfr.skills.vae import SkillVAE
from lfr.tasks import TASKS, task

NAMES = task("lift").observation.names
OSC = embodiment("panda").action.names
SEEN = Seen("panda", ("pick_place",), {"panda-pick_place": "ab"}, 7)


def observations(count: int, seed: int = 0) -> torch.Tensor:
    generator = torch.Generator().manual_seed(seed)
    return 0.2 * torch.randn(count, len(NAMES), generator=generator)


def prior() -> SkillPrior:
    torch.manual_seed(0)
    made = SkillPrior(NAMES, latent_dim=3, hidden=8, layers=2)
    made.normalizer.fit(observations(50), NAMES)
    return made


def test_inputs_that_hardly_vary_are_not_blown_up() -> None:
    made = SkillPrior(NAMES, 3, 8, 2)
    seen = torch.ones(40, len(NAMES)) + 1e-4 * observations(40)
    made.normalizer.fit(seen, NAMES)
    std = dict(zip(NAMES, made.normalizer.std.tolist(), strict=True))
    assert std["eef_pos.x"] == pytest.approx(0.05)
    assert std["eef_rot6d.0"] == pytest.approx(0.2)
    assert std["cube_yaw.cos"] == pytest.approx(0.3)
    assert std["gripper_command"] == pytest.approx(0.3)
    assert std["gripper_aperture"] == pytest.approx(0.01)
    assert std["cube_up.z"] == pytest.approx(0.2)


def test_a_small_tilt_is_magnified_whichever_way_the_hand_is_turned() -> None:
    made = SkillPrior(NAMES, 3, 8, 2)
    layout = task("lift").observation
    for yaw in (0.0, 1.0, -2.5):
        cos, sin, tilt = math.cos(yaw), math.sin(yaw), 0.02
        # The hand points down, turned by yaw, then tilted by a little about the base's y axis.
        x, y = torch.tensor([cos, sin, 0.0]), torch.tensor([sin, -cos, 0.0])
        about_y = torch.tensor(
            [
                [math.cos(tilt), 0.0, math.sin(tilt)],
                [0.0, 1.0, 0.0],
                [-math.sin(tilt), 0.0, math.cos(tilt)],
            ]
        )
        seen = torch.zeros(1, len(NAMES))
        seen[0, layout.slice("eef_rot6d")] = torch.cat([about_y @ x, about_y @ y])
        expected = torch.tensor([-math.tanh(math.sin(tilt) / TILT_SCALE), 0.0])
        torch.testing.assert_close(made.normalizer(seen)[0, -2:], expected, atol=1e-6, rtol=0)


def test_inputs_that_vary_are_standardised() -> None:
    seen = 5.0 + 3.0 * observations(4000) / 0.2
    made = SkillPrior(NAMES, 3, 8, 2)
    made.normalizer.fit(seen, NAMES)
    normal = made.normalizer(seen)[:, : len(NAMES)]
    torch.testing.assert_close(normal.mean(0), torch.zeros(len(NAMES)), atol=1e-4, rtol=0)
    torch.testing.assert_close(normal.std(0), torch.ones(len(NAMES)), atol=1e-3, rtol=0)


def test_saved_models_come_back_identical(tmp_path: Path) -> None:
    torch.manual_seed(0)
    vae, made = SkillVAE(4, 7, 3, 8), prior()
    save_vae(tmp_path / "vae", vae, SEEN)
    save_prior(tmp_path / "prior", made, SEEN)
    z, seen = torch.randn(5, 3), observations(5)
    assert torch.equal(load_vae(tmp_path / "vae").decode(z), vae.decode(z))
    found = load_prior(tmp_path / "prior", NAMES)
    assert all(torch.equal(a, b) for a, b in zip(found(seen), made(seen), strict=True))
    assert load_seen(tmp_path / "vae") == load_seen(tmp_path / "prior") == SEEN


def test_a_prior_of_another_layout_is_refused(tmp_path: Path) -> None:
    save_prior(tmp_path / "prior", prior(), SEEN)
    other = task("stack").observation.names
    with pytest.raises(DataError, match=r"prior/config\.json.*cube_pos\.x.*cubeA_pos\.x"):
        load_prior(tmp_path / "prior", other)


def test_another_kind_of_model_is_refused(tmp_path: Path) -> None:
    save_prior(tmp_path / "prior", prior(), SEEN)
    with pytest.raises(DataError, match=r"another kind of model.*skill_prior.*skill_vae"):
        load_vae(tmp_path / "prior")


@pytest.mark.parametrize("name", TASKS)
def test_a_turned_prior_sees_a_turned_scene_as_the_same(name: str) -> None:
    names = task(name).observation.names
    made, plain = (SkillPrior(names, 3, 8, 2, turned) for turned in (True, False))
    generator = torch.Generator().manual_seed(3)
    seen = torch.randn(40, len(names), generator=generator)
    turn = SymmetryParams(copies=1, turn=3.0, mirror=False, shift=0.0)
    elsewhere = move(seen, names, SceneMotion.draw(40, turn, generator))
    torch.testing.assert_close(made(elsewhere), made(seen), atol=1e-4, rtol=1e-4)
    assert not torch.allclose(plain(elsewhere)[0], plain(seen)[0], atol=1e-2)
    # What it sees is the scene in which the hand is over the x axis, and nothing else of it.
    azimuth = torch.atan2(seen[:, 1], seen[:, 0])
    level = SceneMotion(-azimuth, torch.ones(40), torch.zeros(40, 3), turns_alone=True)
    plain.load_state_dict(made.state_dict())
    torch.testing.assert_close(plain(move(seen, names, level)), made(seen), atol=1e-4, rtol=1e-4)
    made.normalizer.fit(seen, names)
    assert made.normalizer.mean[1] == pytest.approx(0.0, abs=1e-6)


def test_a_turned_prior_comes_back_turned(tmp_path: Path) -> None:
    made = SkillPrior(NAMES, 3, 8, 2, turned=True)
    save_prior(tmp_path / "prior", made, SEEN)
    seen = observations(5)
    found = load_prior(tmp_path / "prior", NAMES)(seen)
    assert all(torch.equal(a, b) for a, b in zip(found, made(seen), strict=True))
