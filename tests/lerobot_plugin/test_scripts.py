"""LeRobot's own scripts, called as a user calls them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lfr.data.dataset import pack_dataset
from lfr.data.episode import EpisodeInfo
from lfr.data.log import EpisodeLog, Frame
from lfr.tasks import task

PLUGIN = "--env.discover_packages_path=lfr.lerobot_plugin"
LIFT = (PLUGIN, "--env.type=lfr", "--env.robot=panda", "--env.task=lift", "--seed=0")


def call(folder: Path, *command: str) -> str:
    """Run a script beside this Python, in a folder, without a network; its output."""
    script = str(Path(sys.executable).with_name(command[0]))
    offline = {"HF_HUB_OFFLINE": "1", "HF_HOME": str(folder / "hub"), "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [script, *command[1:]],
        cwd=folder,
        env={**os.environ, **offline},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:]
    return done.stdout


def metrics(folder: Path) -> dict[str, Any]:
    (only,) = json.loads((folder / "eval_info.json").read_text())["per_task"]
    return only["metrics"]


@pytest.mark.slow
def test_the_command_that_export_prints(saved: Path, tmp_path: Path) -> None:
    command = call(tmp_path, "lfr", "export", str(saved), "policy").splitlines()[-1].split()
    assert command[:2] == ["lerobot-eval", "--policy.path=policy"]
    short = [word for word in command if "n_episodes" not in word]
    call(tmp_path, *short, "--eval.n_episodes=1", "--output_dir=out")
    found = metrics(tmp_path / "out")
    assert len(found["successes"]) == 1
    assert (tmp_path / found["video_paths"][0]).stat().st_size > 0


@pytest.mark.slow
def test_lerobot_train_on_a_dataset_of_ours(tmp_path: Path) -> None:
    pytest.importorskip("accelerate", reason="lerobot-train needs accelerate")
    pack_dataset([log_of(tmp_path, seed) for seed in range(2)], tmp_path / "panda-lift")
    small = {"dim_model": 16, "n_heads": 2, "dim_feedforward": 16, "chunk_size": 10}
    output = call(
        tmp_path,
        "lerobot-train",
        "--dataset.repo_id=lfr/panda-lift",
        "--dataset.root=panda-lift",
        *LIFT,
        "--policy.type=act",
        "--policy.device=cpu",
        "--policy.push_to_hub=false",
        "--policy.n_action_steps=10",
        *(f"--policy.{name}={value}" for name, value in small.items()),
        "--steps=4",
        "--log_freq=1",
        "--env_eval_freq=4",
        "--eval.n_episodes=1",
        "--num_workers=0",
        "--output_dir=act",
    )
    losses = [float(word.split(":")[1]) for word in output.split() if word.startswith("loss:")]
    assert len(losses) == 4
    assert np.isfinite(losses).all()
    checkpoint = tmp_path / "act/checkpoints/last/pretrained_model"
    given = json.loads((checkpoint / "config.json").read_text())["input_features"]
    assert {"observation.state", "observation.environment_state"} <= set(given)
    call(
        tmp_path, "lerobot-eval", f"--policy.path={checkpoint}", *LIFT,
        "--eval.n_episodes=1", "--output_dir=out",
    )  # fmt: skip
    assert len(metrics(tmp_path / "out")["successes"]) == 1


def log_of(folder: Path, seed: int) -> Path:
    """A log in the layout of Lift, of a hand that trembles."""
    layout = task("lift").observation
    info = EpisodeInfo(
        robot="panda",
        task="lift",
        seed=seed,
        instruction=task("lift").instruction,
        state_names=layout.state_names,
        environment_names=layout.environment_names,
    )
    rng = np.random.default_rng(seed)
    path = folder / f"episode-{seed:06d}.mcap"
    with EpisodeLog(path, info) as log:
        for step in range(20):
            log.frame(
                Frame(
                    observation=rng.normal(size=layout.size),
                    joint_position=rng.normal(size=7),
                    action=rng.uniform(-1, 1, size=7),
                    reward=0.0,
                    success=step == 19,
                    simulator_state=np.zeros(1),
                )
            )
        log.finish(simulator_state=np.zeros(1))
    return path
