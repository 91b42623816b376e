"""A demonstration's windows, against the models asked one by one."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from lfr.cli import main
from lfr.data.episode import ACTION, ENVIRONMENT_STATE, STATE
from lfr.embodiments import embodiment
from lfr.errors import DataError, LfrError, UnknownNameError
from lfr.mapping.generator import Generator
from lfr.mapping.saved_generators import MappingSeen, save_generator
from lfr.skills.library import skill_folder
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import Seen, save_prior, save_vae
from lfr.skills.vae import SkillVAE
from lfr.view.skills import carried, divergences
from lfr.view.windows import Gaussians, load_skill_models, trace_windows
from tests.skills.made_up import actions_of

from . import rrd
from .conftest import FRAMES, Recorded

H, Z = 4, 3


@pytest.fixture(scope="module")
def models(recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The mapping of a made-up transfer from Panda to Sawyer, beside the skills, untrained."""
    torch.manual_seed(0)
    root = tmp_path_factory.mktemp("models")
    folder = root / "mapping" / "s9-sawyer-lift"
    names = [n for key in (STATE, ENVIRONMENT_STATE) for n in recorded.episode.schema[key].names]
    for robot in ("panda", "sawyer"):
        seen, skills = Seen(robot, ("lift",), {}, 0), skill_folder(root / "skills", robot, ["lift"])
        save_vae(skills.vae, SkillVAE(H, 7, Z, 8), seen)
        save_prior(skills.prior("lift"), SkillPrior(tuple(names), Z, 8, 2), seen)
    spaces = ("panda/lift", "sawyer/lift")
    learned = MappingSeen("s9-sawyer-lift", "panda", "sawyer", spaces, ("lift",), {}, 0)
    save_generator(folder / "g", Generator(Z, 8, 3), learned)
    return folder


def test_a_window_is_the_next_actions(models: Path, recorded: Recorded) -> None:
    loaded = load_skill_models(models, "lift")
    trace = trace_windows(loaded, recorded.episode)
    assert (trace.arm, len(trace)) == ("source", FRAMES - H + 1)
    columns, t = recorded.episode.features, 3
    with torch.no_grad():
        window = loaded.vaes["source"].encode(torch.tensor(columns[ACTION][None, t : t + H]))
        state = np.concatenate([columns[STATE][t], columns[ENVIRONMENT_STATE][t]])
        prior = loaded.source_prior(torch.tensor(state[None]))
        mapped = loaded.generator(*prior)
        decoded = loaded.vaes["target"].decode(mapped[0])
    found = {"window": trace.window, "prior": trace.prior, "mapped": trace.mapped}
    for name, pair in {"window": window, "prior": prior, "mapped": mapped}.items():
        for part, expected in zip(found[name], pair, strict=True):
            np.testing.assert_allclose(part[t], expected[0], atol=1e-5, err_msg=name)
    np.testing.assert_allclose(trace.decoded["mapped prior"][t], decoded[0], atol=1e-5)


def test_divergences_are_torchs(models: Path, recorded: Recorded) -> None:
    trace = trace_windows(load_skill_models(models, "lift"), recorded.episode)
    names, values = divergences(trace)
    assert names == ["window from source prior", "target prior from G of source prior"]
    assert trace.target_prior is not None
    pairs = ((trace.window, trace.prior), (trace.target_prior, trace.mapped))
    for column, (p, q) in enumerate(pairs):
        kl = torch.distributions.kl_divergence(_normal(p), _normal(q)).sum(1)
        np.testing.assert_allclose(values[:, column], kl.numpy(), rtol=1e-6)


def _normal(gaussians: Gaussians) -> torch.distributions.Normal:
    mu, log_sigma = map(torch.from_numpy, gaussians)
    return torch.distributions.Normal(mu, log_sigma.exp())


def test_the_command_shows_both_spaces(models: Path, dataset: Path, tmp_path: Path) -> None:
    out = tmp_path / "skills.rrd"
    arguments = ["--episode", "0", "--mapping", str(models), "--save", str(out)]
    assert main(["view", str(dataset), *arguments]) == 0
    entities = rrd.read(out)
    for entity in ("source/prior", "source/window", "target/mapped", "target/prior"):
        frames, strips = entities[f"/latent/{entity}/spread"]["LineStrips2D:strips"]
        assert list(frames if frames is not None else ()) == list(range(FRAMES - H + 1))
        assert np.array(strips).shape == (FRAMES - H + 1, Z, 2, 2)
    strips = np.array(entities["/path/window"]["LineStrips3D:strips"][1])
    assert strips.shape == (FRAMES - H + 1, 1, H + 1, 3)


def test_actions_of_another_kind_are_not_compared(
    recorded: Recorded, dataset: Path, tmp_path: Path
) -> None:
    """A source that moves its hand, a target that moves its joints: no window of the one decodes
    to what the other could be held to."""
    names = [n for key in (STATE, ENVIRONMENT_STATE) for n in recorded.episode.schema[key].names]
    folder, robots = tmp_path / "mapping" / "s9-sawyer-lift", ("panda", "sawyer-joint_position")
    for robot in robots:
        seen = Seen(robot, ("lift",), {}, 0, actions_of(robot))
        skills = skill_folder(tmp_path / "skills", robot, ["lift"])
        save_vae(skills.vae, SkillVAE(H, embodiment(robot).action.size, Z, 8), seen)
        save_prior(skills.prior("lift"), SkillPrior(tuple(names), Z, 8, 2), seen)
    spaces = f"{robots[0]}/lift", f"{robots[1]}/lift"
    learned = MappingSeen("s9-sawyer-lift", *robots, spaces, ("lift",), {}, 0)
    save_generator(folder / "g", Generator(Z, 8, 3), learned)
    trace = trace_windows(load_skill_models(folder, "lift"), recorded.episode)
    assert set(trace.decoded) == {"window", "source prior"}
    out = tmp_path / "skills.rrd"
    assert main(["view", str(dataset), "--mapping", str(folder), "--save", str(out)]) == 0
    entities = rrd.read(out)
    assert "/path/prior" in entities
    assert "/path/mapped" not in entities
    assert len(entities["/skill/error"]["SeriesLines:names"][1][0]) == 2


def test_what_is_carried_is_a_least_squares_factor() -> None:
    rng = np.random.default_rng(0)
    wanted = rng.normal(size=(50, 3))
    done = 0.3 * wanted + 0.01 * rng.normal(size=(50, 3))
    expected = np.linalg.lstsq(wanted.reshape(-1, 1), done.ravel(), rcond=None)[0][0]
    assert carried(wanted, done) == pytest.approx(expected)
    assert carried(np.zeros((2, 3)), done[:2]) == 0.0


def test_models_of_others_are_refused(models: Path, recorded: Recorded, tmp_path: Path) -> None:
    with pytest.raises(LfrError, match=r"no prior of 'stack'.*lift"):
        load_skill_models(models, "stack")
    with pytest.raises(DataError, match="no mapping"):
        load_skill_models(tmp_path, "lift")
    with pytest.raises(DataError, match=r"no skill models.*panda/lift"):
        load_skill_models(models, "lift", tmp_path)
    loaded = load_skill_models(models, "lift")
    with pytest.raises(UnknownNameError, match="panda, sawyer"):
        trace_windows(loaded, replace(recorded.episode, robot="ur5e"))
    short = {key: column[: H - 1] for key, column in recorded.episode.features.items()}
    with pytest.raises(DataError, match="too short"):
        trace_windows(loaded, replace(recorded.episode, features=short))
