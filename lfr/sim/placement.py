"""Where an episode starts: stock robosuite's reset distributions, drawn in stock's own order.

A generator in the same state gives the same start here as in stock robosuite, so a seed names one
start for the engine and for the oracle alike.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class ObjectPlacement:
    """One object's region (m, world frame), as robosuite's `UniformRandomSampler` has it.

    Attributes:
        joint: the object's free joint.
        x_range, y_range: bounds of the object's origin.
        z: height at which the object is let go.
        radius, bottom, top: the object's extent, for the overlap check.
        check_overlap: draw again while the object overlaps one that is already placed.
    """

    joint: str
    x_range: tuple[float, float]
    y_range: tuple[float, float]
    z: float
    radius: float
    bottom: float
    top: float
    check_overlap: bool


@dataclass(frozen=True)
class StartDistribution:
    """All that is random at the start of an episode.

    Attributes:
        joint_position: (7,) rad, the arm's nominal start.
        joint_noise: standard deviation (rad) of Gaussian noise on it.
        objects: in the order in which stock draws them, those that it parks afterwards too, since
            they keep others out of their place.
        size_range: half sizes (m) of Lift's cube, or None where nothing is drawn.
    """

    joint_position: NDArray[np.float64]
    joint_noise: float
    objects: tuple[ObjectPlacement, ...]
    size_range: tuple[tuple[float, ...], tuple[float, ...]] | None

    def sample(self, seed: int) -> "Start":
        """The start named by `seed`."""
        rng = np.random.default_rng(seed)
        size = None
        if self.size_range is not None:
            size = np.array([_draw(rng, *bounds) for bounds in zip(*self.size_range, strict=True)])
        noise = rng.standard_normal(len(self.joint_position)) * self.joint_noise
        placed: list[tuple[float, float, ObjectPlacement]] = []
        poses = {}
        for item in self.objects:
            # The cube's size moves the height at which it is let go.
            z = item.z if size is None else item.z + float(size[2])
            x, y = _free_place(item, placed, rng)
            angle = _draw(rng, 0.0, 2.0 * np.pi)
            quaternion = (np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2))
            poses[item.joint] = np.array([x, y, z, *quaternion])
            placed.append((x, y, item))
        return Start(self.joint_position + noise, poses, size)


@dataclass(frozen=True)
class Start:
    """One episode's start: joints (7,) rad, object poses (7,) by joint, cube half size (3,) m."""

    joint_position: NDArray[np.float64]
    object_poses: dict[str, NDArray[np.float64]]
    cube_size: NDArray[np.float64] | None


def _free_place(
    item: ObjectPlacement,
    placed: list[tuple[float, float, ObjectPlacement]],
    rng: np.random.Generator,
) -> tuple[float, float]:
    while True:
        x, y = _draw(rng, *item.x_range), _draw(rng, *item.y_range)
        if not item.check_overlap or not any(
            np.hypot(x - other_x, y - other_y) <= other.radius + item.radius
            and item.z - other.z <= other.top - item.bottom
            for other_x, other_y, other in placed
        ):
            return x, y


def _draw(rng: np.random.Generator, low: float, high: float) -> float:
    """What `rng.uniform` draws, bit for bit, at a fifth of its time for a single number."""
    return low + (high - low) * rng.random()


def start_distribution(environment: Any) -> StartDistribution:
    """Read the start distribution off a stock robosuite environment."""
    arm = environment.robots[0]
    sampler = environment.placement_initializer
    samplers = list(getattr(sampler, "samplers", {"": sampler}).values())
    cube = getattr(environment, "cube", None)
    objects = tuple(
        _placement(inner, item, sized=cube is None)
        for inner in samplers
        for item in inner.mujoco_objects
        if item.joints
    )
    return StartDistribution(
        joint_position=np.array(arm.init_qpos, dtype=np.float64),
        joint_noise=float(arm.initialization_noise["magnitude"]),
        objects=objects,
        # robosuite/environments/manipulation/lift.py; the bounds are literals there
        size_range=None if cube is None else ((0.020,) * 3, (0.022,) * 3),
    )


def _placement(sampler: Any, item: Any, *, sized: bool) -> ObjectPlacement:
    margin = item.horizontal_radius if sampler.ensure_object_boundary_in_range else 0.0
    reference = np.asarray(sampler.reference_pos, dtype=np.float64)
    bottom = float(item.bottom_offset[2])

    def bounds(interval: tuple[float, float], origin: float) -> tuple[float, float]:
        return interval[0] + margin + origin, interval[1] - margin + origin

    return ObjectPlacement(
        joint=item.joints[0],
        x_range=bounds(sampler.x_range, reference[0]),
        y_range=bounds(sampler.y_range, reference[1]),
        z=float(sampler.z_offset + reference[2]) - (bottom if sized else 0.0),
        radius=float(item.horizontal_radius),
        bottom=bottom,
        top=float(item.top_offset[2]),
        check_overlap=bool(sampler.ensure_valid_placement),
    )
