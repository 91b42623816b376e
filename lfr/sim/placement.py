"""Reading the start distribution off a stock robosuite environment."""

from typing import Any

import mujoco
import numpy as np

from lfr.sim.start import StartArrays
from lfr.tasks import Task


def start_arrays(environment: Any, model: mujoco.MjModel, task: Task) -> StartArrays:
    """The start distribution of `environment`, for the pruned `model` of its scene."""
    arm = environment.robots[0]
    sampler = environment.placement_initializer
    samplers = list(getattr(sampler, "samplers", {"": sampler}).values())
    placed = [(s, item) for s in samplers for item in s.mujoco_objects if item.joints]
    bottoms = np.array([float(item.bottom_offset[2]) for _, item in placed])
    tops = np.array([float(item.top_offset[2]) for _, item in placed])
    radii = np.array([float(item.horizontal_radius) for _, item in placed])
    floors = np.array([float(s.z_offset + s.reference_pos[2]) for s, _ in placed])
    sizes = (task.sized.low, task.sized.high) if task.sized else (0.0, 0.0)
    return StartArrays(
        joint_position=np.array(arm.init_qpos, dtype=np.float64),
        joint_noise=float(arm.initialization_noise["magnitude"]),
        open_fingers=np.array(arm.gripper["right"].init_qpos, dtype=np.float64),
        regions=np.array([_region(*pair) for pair in placed]),
        heights=floors if task.sized else floors - bottoms,
        extents=np.stack([radii, bottoms, tops], axis=1),
        check_overlap=np.array([bool(s.ensure_valid_placement) for s, _ in placed]),
        addresses=np.array([_address(model, item.joints[0]) for _, item in placed]),
        sized=task.sized is not None,
        sizes=np.tile(sizes, (3, 1)),
    )


def _region(sampler: Any, item: Any) -> list[list[float]]:
    """Bounds (2, 2) of the object's origin, x and y, low and high."""
    margin = item.horizontal_radius if sampler.ensure_object_boundary_in_range else 0.0
    origin = np.asarray(sampler.reference_pos, dtype=np.float64)
    ranges = (sampler.x_range, sampler.y_range)
    return [
        [interval[0] + margin + origin[axis], interval[1] - margin + origin[axis]]
        for axis, interval in enumerate(ranges)
    ]


def _address(model: mujoco.MjModel, joint: str) -> int:
    found = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint)
    return int(model.jnt_qposadr[found]) if found >= 0 else -1
