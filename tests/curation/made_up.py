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


KINDS = {
    "observation.state": {"dtype": "float64", "shape": (2,), "names": {"motors": ["a", "b"]}},
    "observation.pose": {"dtype": "float32", "shape": (2, 3), "names": None},
    "observation.count": {"dtype": "int32", "shape": (1,), "names": None},
    "observation.touch": {"dtype": "bool", "shape": (2,), "names": [["left", "right"]]},
    "observation.level": {"dtype": "uint8", "shape": (4,), "names": None},
    "observation.note": {"dtype": "string", "shape": (1,), "names": None},
    "observation.images.eye": {"dtype": "image", "shape": (3, 32, 48),
                               "names": ["channels", "height", "width"]},
    "action": {"dtype": "float32", "shape": (1,), "names": ["only"]},
}  # fmt: skip


def record_every_kind(root: Path, *, without: str = "") -> Path:
    """Every type that LeRobot records, four episodes of two rows and more, in several files."""
    from lerobot.datasets import LeRobotDataset

    features: dict[str, Any] = {key: kind for key, kind in KINDS.items() if key != without}
    recorded = LeRobotDataset.create("theirs/kinds", 25, features, root=root, use_videos=False)
    recorded.meta.update_chunk_settings(data_files_size_in_mb=0.02)
    rng = np.random.default_rng(0)
    for episode, length in enumerate((30, 2, 3, 45)):
        for t in range(length):
            frame = {
                "observation.state": rng.normal(5, 1, 2),
                "observation.pose": rng.normal(0, 1, (2, 3)).astype(np.float32),
                "observation.count": np.array([t**3], np.int32),
                "observation.touch": rng.random(2) < 0.5,
                "observation.level": rng.integers(0, 255, 4).astype(np.uint8),
                "observation.note": "é",
                "observation.images.eye": made_up.picture(episode, t, 48)[:32],
                "action": rng.normal(0, 1, 1).astype(np.float32),
                "task": ["Reach.", "Zurück."][(t + episode) % 2],
            }
            recorded.add_frame({k: v for k, v in frame.items() if k != without})
        recorded.save_episode()
    recorded.finalize()
    return root
