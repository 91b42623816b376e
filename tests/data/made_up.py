"""Made-up episodes: random numbers in the shapes of real ones, no simulator."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from lfr.data.episode import EpisodeInfo, Feature, features
from lfr.data.log import EpisodeLog, Frame
from lfr.embodiments import embodiment

Make = Callable[[int, int, int], list[Frame]]
"""Makes the frames of a seed, so many, with pictures of so many pixels."""

STATE_NAMES = ("eef_pos.x", "eef_pos.y", "eef_pos.z", "gripper_aperture")
BODIES = ("hand", "cube")
ENVIRONMENT_NAMES = ("cube_pos.x", "cube_pos.y", "cube_pos.z")


def layout(
    environment: Sequence[str] = ENVIRONMENT_NAMES, robot: str = "panda"
) -> dict[str, Feature]:
    """Of an embodiment that is known, with less of an observation than it has."""
    body = embodiment(robot)
    return features(STATE_NAMES, environment, body.robot.joints, body.action.names)


def info(seed: int = 0, robot: str = "panda", task: str = "lift") -> EpisodeInfo:
    return EpisodeInfo(robot, task, seed, "Lift the cube.", layout(robot=robot))


def frames(seed: int, length: int, image_size: int = 0, robot: str = "panda") -> list[Frame]:
    rng, body = np.random.default_rng(seed), embodiment(robot)
    joints = len(body.robot.joints)
    return [
        Frame(
            observation=rng.normal(size=7),
            joint_position=rng.normal(size=joints),
            joint_velocity=rng.normal(size=joints),
            action=rng.uniform(-1, 1, size=body.action.size),
            reward=float(rng.normal()),
            success=t == length - 1,
            simulator_state=rng.normal(size=30),
            body_poses={
                name: (rng.normal(size=3), rng.normal(size=4)) for name in ("hand", "cube")
            },
            images={"agentview": picture(seed, t, image_size)} if image_size else {},
        )
        for t in range(length)
    ]


def picture(seed: int, t: int, size: int) -> np.ndarray:
    """(size, size, 3) uint8: a smooth gradient, brighter with t: frames can be told apart."""
    ramp = np.linspace(0, 100, size)
    image = np.empty((size, size, 3))
    image[..., 0] = ramp + 10 * t
    image[..., 1] = ramp[:, None]
    image[..., 2] = 20 * seed
    return image.clip(0, 255).astype(np.uint8)


def write(
    path: Path, seed: int, length: int, image_size: int = 0, make: Make = frames
) -> list[Frame]:
    """Log the made-up episode of this seed; gives back what was logged."""
    logged = make(seed, length, image_size)
    with EpisodeLog(path, info(seed)) as log:
        for frame in logged:
            log.frame(frame)
        log.finish(np.arange(30.0), body_poses=logged[-1].body_poses)
    return logged


def write_all(
    folder: Path, lengths: Sequence[int], image_size: int = 0, make: Make = frames
) -> list[Path]:
    paths = [folder / f"episode-{i:06d}.mcap" for i in range(len(lengths))]
    for seed, (path, length) in enumerate(zip(paths, lengths, strict=True)):
        write(path, seed, length, image_size, make)
    return paths
