"""The whole command at a size that runs in seconds: nothing is learned, everything is run."""

from __future__ import annotations

from pathlib import Path

import pytest

from studies.evidence import __main__ as command
from studies.evidence.runs import read_curves, read_runs

PARAMS = """
record: {episodes: 3}
skills:
  jacobian: {hidden: 8, steps: 20, batch: 32, learning_rate: 1.0e-3}
  vae: {hidden: 16, latent_dim: 4, steps: 20, batch: 16}
  prior: {hidden: 16, layers: 2, steps: 20, batch: 16, symmetry: {copies: 1}}
  held_out: 0.34
mapping: {hidden: 16, steps: 10, batch: 16, hand: {batch: 8}}
transfer:
  steps: 150
  batch: 8
  critic_hidden: [16]
  simulations: 2
  warm_up: 50
  replay: 100
  evaluate_every: 150
  evaluation_episodes: 1
  checkpoint_every: 100
"""

ASKED = """
scenarios:
  a: {common: [lift], new: {ur5e-joint_position: stack},
      arms: [ur5e-joint_position, panda-joint_position]}
  b: {common: [lift], new: {ur5e-joint_position: stack}, arms: [ur5e-joint_position, panda]}
matrix: {arms: [panda, ur5e], controller: joint_position, common: [lift], task: stack}
options:
  ours: {}
  paper: {mapping: {condition: none, hand: {weight: 0.0}}}
methods: {sac: {updates_per_skill: 0.1}}
imitation: {hidden: 8, layers: 1, horizon: 4, modes: 2, updates: 3}
episodes: 2
stock_episodes: 1
settings:
  all:
    transfers: [a-ur5e-joint_position-stack]
    seeds: 2
    links: true
    options: [paper]
    methods: [lfr, ap, sac, bc_rnn, retarget, spirl, no_generator]
    learned: [paper]
    stock: [lfr]
  languages: {transfers: [b-ur5e-joint_position-stack], seeds: 1, links: true}
  matrix: {transfers: [matrix], seeds: 1, links: true}
"""

LINKS = {"own_arm", "identity", "no_generator", "recoded", "linear", "lfr", "retarget", "oracle"}


@pytest.mark.slow
def test_everything_is_run_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("params.yaml").write_text(PARAMS)
    Path("asked.yaml").write_text(ASKED)
    command.main(asked="asked.yaml")
    runs = read_runs()
    assert all(run.starts == len(run.outcomes) for run in runs)
    assert all(run.successes == run.outcomes.count("1") for run in runs)

    name = "a-ur5e-joint_position-stack"
    of_first = [run for run in runs if run.transfer == name and run.seed == 1]
    assert {run.method for run in of_first if not run.env_steps} == {*LINKS, "bc_rnn"}
    options = {(run.method, run.option) for run in of_first if run.env_steps}
    assert options == {
        ("lfr", "ours"), ("lfr", "paper"), ("ap", ""), ("sac", ""), ("retarget", ""),
        ("spirl", ""), ("no_generator", ""),
    }  # fmt: skip
    stock = [(run.method, run.starts) for run in of_first if run.judge == "robosuite"]
    assert stock == [("lfr", 1)]
    assert {run.transfer for run in runs} == {
        name, "b-ur5e-joint_position-stack",
        "matrix-panda-joint_position-ur5e-joint_position-stack",
        "matrix-ur5e-joint_position-panda-joint_position-stack",
    }  # fmt: skip
    curve = [point.env_steps for point in read_curves() if point.key[:3] == (name, "lfr", "ours")]
    assert curve.count(0) == 2  # seeds

    before = Path("results/evidence/runs.csv").read_bytes()
    command.main(setting="all", asked="asked.yaml")
    assert Path("results/evidence/runs.csv").read_bytes() == before
