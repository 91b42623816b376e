"""Scenes as they were built, kept on disk, so that a later start needs no robosuite.

Importing robosuite and building a scene takes longer than all else in a start. A kept scene is
named by the versions of robosuite and MuJoCo and by the sources that build it; one file holds the
compiled model, the kernel's arrays and the start distribution.
"""

from __future__ import annotations

import functools
import hashlib
import logging
import os
import zipfile
from importlib import metadata
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import lfr.tasks
from lfr.compiled.arrays import SceneArrays
from lfr.embodiments import embodiment
from lfr.sim.compilation import writable_folder
from lfr.sim.scene import Scene, build_scene
from lfr.sim.start import StartArrays

_LOG = logging.getLogger(__name__)
_SOURCES = (
    *(
        "sim/pads.py",
        "sim/placement.py",
        "sim/scene.py",
        "sim/start.py",
        "sim/stock.py",
        "sim/stock_grippers.py",
    ),
    *("embodiments.py", "spaces.py", "compiled/*.py", "controllers/*.py", "robots/*.py"),
    "tasks/*.py",
)


def load_scene(name: str, task: str) -> Scene:
    """The scene of `task` with an embodiment: a kept one if there is, else built and kept.

    Raises:
        UnknownNameError: unknown embodiment or task.
        LfrError: robosuite's model is not laid out as the kernel needs it.
    """
    body, chosen = embodiment(name), lfr.tasks.task(task)
    folder = scene_folder()
    if folder is None:
        return build_scene(name, task)
    path = folder / f"{body.name}-{chosen.name}.npz"
    if path.exists():
        try:
            return _read(path, name, task)
        except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
            _LOG.warning("%s cannot be read (%s); building the scene anew", path, error)
    scene = build_scene(name, task)
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
    for pattern in _SOURCES:
        for source in sorted(package.glob(pattern)):
            digest.update(source.read_bytes())
    return writable_folder(f"scenes-{digest.hexdigest()[:16]}")


def _write(path: Path, scene: Scene) -> None:
    model = np.empty(mujoco.mj_sizeModel(scene.model), dtype=np.uint8)
    mujoco.mj_saveModel(scene.model, None, model)
    parts = {"arrays": scene.arrays, "start": scene.start}
    arrays = {f"{p}.{name}": v for p, part in parts.items() for name, v in part._asdict().items()}
    # Several processes may build it at once; each renames a whole file of its own into place.
    partial = path.with_name(f".{path.stem}-{os.getpid()}.npz")
    np.savez(partial, model=model, **arrays)
    partial.replace(path)


def _read(path: Path, name: str, task: str) -> Scene:
    with np.load(path, allow_pickle=False) as kept:
        model = mujoco.MjModel.from_binary_path("scene.mjb", {"scene.mjb": kept["model"].tobytes()})
        arrays = SceneArrays(**_part(kept, "arrays", SceneArrays._fields))
        start = StartArrays(**_part(kept, "start", StartArrays._fields))
    return Scene(embodiment(name), lfr.tasks.task(task), model, arrays, start)


def _part(kept: Any, part: str, fields: tuple[str, ...]) -> dict[str, Any]:
    """Numbers come back as arrays without a dimension."""
    values = {name: kept[f"{part}.{name}"] for name in fields}
    return {name: v if v.ndim else v.item() for name, v in values.items()}
