"""Made-up files in robomimic's layout, as its dataset_states_to_obs.py and split scripts write it.

`data` with `total` and `env_args`; `demo_N` with `num_samples` and `model_file`, float64 arrays,
`dones` of int64; `mask`, byte strings. Demonstrations are created out of order.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

LENGTHS = {"demo_10": 9, "demo_0": 12, "demo_2": 7}
ENV_ARGS = {
    "env_name": "Lift",
    "env_version": "1.4.1",
    "type": 1,
    "env_kwargs": {
        "robots": ["Panda"],
        "control_freq": 20,
        "controller_configs": {"type": "OSC_POSE", "control_delta": True},
    },
}
MASKS = {"train": ("demo_10", "demo_0"), "valid": ("demo_2",), "20_percent": ("demo_0",)}


def demo(seed: int, length: int, image_size: int = 0) -> dict[str, np.ndarray]:
    """Arrays of a demonstration that succeeds in its last frame."""
    rng = np.random.default_rng(seed)
    quaternions = rng.normal(size=(length, 4))
    succeeds = np.arange(length) == length - 1
    arrays = {
        "actions": rng.uniform(-1, 1, size=(length, 7)),
        "states": rng.normal(size=(length, 32)),
        "rewards": succeeds.astype(np.float64),
        "dones": succeeds.astype(np.int64),
        "obs/robot0_eef_pos": rng.normal(size=(length, 3)),
        "obs/robot0_eef_quat": quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True),
        "obs/robot0_gripper_qpos": rng.normal(size=(length, 2)),
        "obs/robot0_joint_pos": rng.normal(size=(length, 7)),
        "obs/robot0_joint_vel": rng.normal(size=(length, 7)),
        "obs/object": rng.normal(size=(length, 10)),
    }
    if image_size:
        ramp = np.linspace(0, 100, image_size)
        image = np.empty((length, image_size, image_size, 3))
        image[..., 0] = ramp + 10 * np.arange(length)[:, None, None]  # frames can be told apart
        image[..., 1] = ramp[:, None]
        image[..., 2] = 20
        arrays["obs/agentview_image"] = image.astype(np.uint8)
    return arrays


def demos(image_size: int = 0) -> dict[str, dict[str, np.ndarray]]:
    return {
        name: demo(seed, length, image_size) for seed, (name, length) in enumerate(LENGTHS.items())
    }


def write(
    path: Path,
    content: Mapping[str, Mapping[str, np.ndarray]],
    env_args: Mapping[str, Any] = ENV_ARGS,
    masks: Mapping[str, tuple[str, ...]] = MASKS,
) -> Path:
    import h5py

    with h5py.File(path, "w") as file:
        data = file.create_group("data")
        data.attrs["total"] = sum(len(arrays["actions"]) for arrays in content.values())
        data.attrs["env_args"] = json.dumps(env_args, indent=4)
        for name, arrays in content.items():
            group = data.create_group(name)
            group.attrs["num_samples"] = len(arrays["actions"])
            group.attrs["model_file"] = f"<mujoco model='{name}'/>"
            for key, values in arrays.items():
                group.create_dataset(key, data=values)
                if key.startswith("obs/"):
                    group.create_dataset(f"next_{key}", data=np.roll(values, -1, axis=0))
        for mask, names in masks.items():
            file[f"mask/{mask}"] = np.array(names, dtype="S")
    return path
