"""Made-up episodes whose values could be real ones, logged by us or recorded by LeRobot."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from lfr.data.log import Frame
from tests.data import made_up

THEIRS = {
    "observation.state": {"dtype": "float32", "shape": (3,), "names": ["x", "y", "z"]},
    "action": {"dtype": "float32", "shape": (2,), "names": ["left", "right"]},
    "observation.images.top": {
        "dtype": "video",
        "shape": (64, 96, 3),
        "names": ["height", "width", "channels"],
    },
}


def frames(seed: int, length: int, image_size: int = 0) -> list[Frame]:
    """As `tests.data.made_up.frames`, in the ranges of metres, radians and dense rewards."""
    return [
        replace(
            frame,
            observation=np.tanh(frame.observation) * ([1.0] * 3 + [0.01] + [1.0] * 3),
            joint_position=np.tanh(frame.joint_position),
            reward=float(np.tanh(frame.reward) ** 2),
        )
        for frame in made_up.frames(seed, length, image_size)
    ]


write = partial(made_up.write, make=frames)
write_all = partial(made_up.write_all, make=frames)


def record_with_lerobot(root: Path) -> Path:
    """Three episodes, two tasks, 30 fps, so unlike each other that quantiles average badly."""
    from lerobot.datasets import LeRobotDataset

    features: dict[str, Any] = THEIRS
    recorded = LeRobotDataset.create("theirs/reach", 30, features, root=root, robot_type="so100")
    rng = np.random.default_rng(0)
    for episode, length in enumerate((25, 40, 31)):
        for t in range(length):
            image = made_up.picture(episode, t, 96)[:64]
            recorded.add_frame(
                {
                    "observation.state": rng.normal(10 * episode, 1, 3).astype(np.float32),
                    "action": rng.normal(0, 100**episode, 2).astype(np.float32),
                    "observation.images.top": image,
                    "task": ["Reach.", "Return."][episode % 2],
                }
            )
        recorded.save_episode()
    recorded.finalize()
    return root
