"""One short episode of Panda on Lift, logged and shown once for all the tests of this folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lfr.data.dataset import pack_dataset
from lfr.data.episode import (
    ACTION,
    ENVIRONMENT_STATE,
    JOINT_POSITION,
    STATE,
    Episode,
    EpisodeInfo,
)
from lfr.data.log import EpisodeLog, Frame
from lfr.data.log_reader import read_log
from lfr.data.messages import CameraModel, Pose
from lfr.embodiments import embodiment
from lfr.tasks import task

FRAMES = 12
INTRINSICS = np.array([[50.0, 0.0, 32.0], [0.0, 50.0, 32.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Recorded:
    """A log, what it holds, and the poses that MuJoCo gave: body -> (FRAMES + 1, 7)."""

    log: Path
    episode: Episode
    poses: dict[str, NDArray[np.float64]]


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    from lfr.sim.simulation import simulation

    sim = simulation("panda", "lift")
    observation = sim.reset(5)
    info = EpisodeInfo.of(sim.embodiment, sim.task, 5)
    path = tmp_path_factory.mktemp("logs") / "panda-lift" / "episode-000000.mcap"
    rng, rows = np.random.default_rng(0), []
    cameras = {
        "agentview": CameraModel(64, 64, INTRINSICS, np.ones(3), np.array([1.0, 0.0, 0.0, 0.0])),
        "wrist": CameraModel(64, 64, INTRINSICS),
    }

    def bodies() -> dict[str, Pose]:
        """And the wrist's camera, wherever the hand is."""
        poses = sim.body_poses()
        return {**poses, "wrist": poses["robot0_right_hand"]}

    with EpisodeLog(path, info, cameras) as log:
        for t in range(FRAMES):
            action = rng.uniform(-1, 1, 7)
            poses = bodies()
            rows.append(poses)
            frame = Frame(
                observation=observation,
                joint_position=sim.joint_position(),
                action=action,
                reward=0.1 * t,
                success=t > 8,
                simulator_state=sim.state(),
                body_poses=poses,
                images={
                    "agentview": np.full((64, 64, 3), 20 * t, np.uint8),
                    "wrist": np.full((64, 64, 3), 255 - 20 * t, np.uint8),
                },
            )
            observation = sim.step(action[None]).observations[0]
            log.frame(frame)
        rows.append(bodies())
        log.finish(sim.state(), rows[-1])
    poses = {name: np.array([np.concatenate(row[name]) for row in rows]) for name in rows[0]}
    return Recorded(path, read_log(path), poses)


def write_again(recorded: Recorded, path: Path, seed: int, frames: int, won: bool) -> Path:
    """The first frames of the episode as another log, of another seed and outcome."""
    episode = recorded.episode
    info = EpisodeInfo.of(embodiment("panda"), task("lift"), seed)
    columns = episode.features

    def poses(t: int) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        return {body: (rows[t, :3], rows[t, 3:]) for body, rows in recorded.poses.items()}

    with EpisodeLog(path, info) as log:
        for t in range(frames):
            log.frame(
                Frame(
                    observation=np.concatenate([columns[STATE][t], columns[ENVIRONMENT_STATE][t]]),
                    joint_position=columns[JOINT_POSITION][t],
                    action=columns[ACTION][t],
                    reward=0.1 * t,
                    success=won and t == frames - 1,
                    simulator_state=episode.simulator_state[t],
                    body_poses=poses(t),
                )
            )
        log.finish(episode.simulator_state[frames], poses(frames))
    return path


LOGS = ((7, 12, True), (3, 5, False), (11, 9, True))
"""Seed, frames and success of each log of a folder."""


@pytest.fixture(scope="session")
def logs(recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of three logs."""
    folder = tmp_path_factory.mktemp("several") / "panda-lift"
    for number, (seed, frames, won) in enumerate(LOGS):
        write_again(recorded, folder / f"episode-{number:06d}.mcap", seed, frames, won)
    return folder


@pytest.fixture(scope="session")
def dataset(logs: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The three logs as a dataset without pictures."""
    out = tmp_path_factory.mktemp("packed") / "panda-lift"
    pack_dataset(sorted(logs.glob("*.mcap")), out, video=False)
    return out


@pytest.fixture(scope="session")
def shown(recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The episode's `.rrd`, as `lfr view LOG --save` writes it."""
    from lfr.cli import main

    path = tmp_path_factory.mktemp("shown") / "episode.rrd"
    assert main(["view", str(recorded.log), "--save", str(path)]) == 0
    return path
