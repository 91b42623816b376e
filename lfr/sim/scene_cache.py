"""Scenes as they were built, kept on disk, so that a later start needs no robosuite.

Importing robosuite and building a scene takes longer than all else in a start. A kept scene is
named by the versions of robosuite and MuJoCo and by the sources that build it; one file holds the
compiled model, the kernel's arrays and the start distribution.
"""

from __future__ import annotations

import functools
import hashlib
import json
import logging
import os
import zipfile
from dataclasses import asdict
from importlib import metadata
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import lfr.robots
import lfr.tasks
from lfr.sim.compilation import writable_folder
from lfr.sim.placement import ObjectPlacement, StartDistribution
from lfr.sim.scene import Scene, SceneArrays, build_scene

_LOG = logging.getLogger(__name__)
_SOURCES = ("sim/placement.py", "sim/scene.py", "sim/stock.py", "robots.py", "tasks.py")


def load_scene(robot: str, task: str) -> Scene:
    """The scene of `task` with `robot`: a kept one if there is, else built and kept.

    Raises:
        UnknownNameError: unknown robot or task.
        LfrError: robosuite's model is not laid out as the kernel needs it.
    """
    arm, chosen = lfr.robots.robot(robot), lfr.tasks.task(task)
    folder = scene_folder()
    if folder is None:
        return build_scene(robot, task)
    path = folder / f"{arm.name}-{chosen.name}.npz"
    if path.exists():
        try:
            return _read(path, robot, task)
        except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
            _LOG.warning("%s cannot be read (%s); building the scene anew", path, error)
    scene = build_scene(robot, task)
    try:
        _write(path, scene)
    except OSError as error:
        _LOG.warning("%s cannot be written (%s); every start builds the scene anew", path, error)
    return scene


@functools.cache
def scene_folder() -> Path | None:
    """Where scenes of these versions are kept, or None where nothing can be written."""
    package = Path(__file__).parent.parent
    digest = hashlib.sha256(f"{mujoco.__version__} {metadata.version('robosuite')}".encode())
    for name in _SOURCES:
        digest.update((package / name).read_bytes())
    return writable_folder(f"scenes-{digest.hexdigest()[:16]}")


def _write(path: Path, scene: Scene) -> None:
    model = np.empty(mujoco.mj_sizeModel(scene.model), dtype=np.uint8)
    mujoco.mj_saveModel(scene.model, None, model)
    arrays = {f"arrays.{name}": value for name, value in scene.arrays._asdict().items()}
    start = asdict(scene.start)
    start["joint_position"] = scene.start.joint_position.tolist()
    # Several processes may build it at once; each renames a whole file of its own into place.
    partial = path.with_name(f".{path.stem}-{os.getpid()}.npz")
    np.savez(
        partial, model=model, start=json.dumps(start), open_fingers=scene.open_fingers, **arrays
    )
    partial.replace(path)


def _read(path: Path, robot: str, task: str) -> Scene:
    with np.load(path, allow_pickle=False) as kept:
        model = mujoco.MjModel.from_binary_path("scene.mjb", {"scene.mjb": kept["model"].tobytes()})
        # Numbers come back as arrays without a dimension.
        values: dict[str, Any] = {name: kept[f"arrays.{name}"] for name in SceneArrays._fields}
        values = {name: v if v.ndim else v.item() for name, v in values.items()}
        start = json.loads(str(kept["start"]))
        fingers = kept["open_fingers"]
    objects = start.pop("objects")
    return Scene(
        robot=lfr.robots.robot(robot),
        task=lfr.tasks.task(task),
        model=model,
        arrays=SceneArrays(**values),
        start=StartDistribution(
            joint_position=np.array(start["joint_position"]),
            joint_noise=start["joint_noise"],
            objects=tuple(ObjectPlacement(**_tuples(item)) for item in objects),
            size_range=_tuples(start)["size_range"],
        ),
        open_fingers=fingers,
    )


def _tuples(value: Any) -> Any:
    """JSON's lists as the tuples that they were."""
    if isinstance(value, dict):
        return {name: _tuples(item) for name, item in value.items()}
    return tuple(_tuples(item) for item in value) if isinstance(value, list) else value
