"""The demo at a size that runs in seconds, and how an attempt is filmed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from lfr.artifacts import read_json
from lfr.params import read_yaml
from lfr.policies import run_episode
from lfr.seeds import episode_seed
from lfr.sim.simulation import simulation
from pipeline import _demo
from pipeline._film import SECONDS, Filmed

TINY = """
record: {episodes: 3, cameras: []}
skills:
  vae: {hidden: 16, latent_dim: 4, steps: 20, batch: 16}
  prior: {hidden: 16, layers: 2, steps: 20, batch: 16}
  held_out: 0.34
mapping: {hidden: 16, steps: 20, batch: 16}
evaluate: {episodes: 2, judges: [engine]}
"""


@pytest.mark.slow
def test_it_says_what_came_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    whole = read_yaml(_demo.PARAMS)
    kept = ("robots", "scenarios", "transfers", "external", "seeds", "pack")
    params = tmp_path / "params.yaml"
    params.write_text("".join(f"{key}: {whole[key]}\n" for key in kept) + TINY)
    monkeypatch.setattr(_demo, "PARAMS", params)
    monkeypatch.chdir(tmp_path)
    _demo.main()
    told = capsys.readouterr().out
    (transfer,) = whole["transfers"]
    found = read_json(Path("results/chain") / f"{transfer}.json")["zero_shot"]  # in its folder now
    for link in ("identity", "no_generator", "linear", "mapped"):
        assert f"  {found[link]['successes']:3d} of 2  {_demo.WORDS[link]}\n" in told
    assert "[7 of 7]" in told
    picture = tmp_path / _demo.FOLDER / _demo.PICTURE
    assert f"The picture: {_demo.FOLDER / _demo.PICTURE}" in told
    with Image.open(picture) as image:
        assert image.format == "PNG"
        assert np.asarray(image.convert("L")).std() > 10  # something is drawn


def test_its_scenario_is_one_of_arms_whose_actions_differ() -> None:
    params = read_yaml(_demo.PARAMS)
    assert params["robots"] == params["scenarios"]["demo"]["arms"][::-1]
    assert all(robot.endswith("-joint_position") for robot in params["robots"])


def test_a_filmed_episode_is_the_episode() -> None:
    class Reach:
        """Down and a little to the side, as joint motions."""

        def reset(self, seed: int) -> None:
            pass

        def act(self, observation: np.ndarray) -> np.ndarray:
            return np.tile(np.linspace(-0.2, 0.3, 8), (5, 1))

    plain = simulation("panda-joint_position", "lift")
    filmed = Filmed(plain)
    if filmed._camera is None:
        pytest.skip("no OpenGL")
    seed = episode_seed("learning", 5)
    seen = run_episode(Reach(), filmed, seed)
    assert len(filmed.heights) == filmed.horizon + 1
    assert len(filmed.pictures) == len(SECONDS)
    observation = plain.reset(seed)
    place = plain.layout.names.index("cube_pos.z")
    assert filmed.heights[0] == observation[place]
    steps = plain.step(np.tile(np.linspace(-0.2, 0.3, 8), (filmed.horizon, 1)))
    np.testing.assert_array_equal(filmed.heights[1:], steps.observations[:, place])
    assert (seen.success, seen.steps) == (False, filmed.horizon)
    moved = [np.abs(picture.astype(int) - filmed.pictures[0]).mean() for picture in filmed.pictures]
    assert moved[0] == 0.0
    assert min(moved[1:]) > 0.5
