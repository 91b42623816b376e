"""What a camera draws: robosuite's model with its visual geoms, without what no picture shows.

A software renderer spends its time on triangles, and an arm has far more of them than a small
picture has pixels, most of them out of sight or smaller than a pixel.
"""

import functools
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

import lfr.embodiments
import lfr.tasks
from lfr.sim.camera_params import STOCK_NAMES
from lfr.sim.stock import make_stock_environment, repaired_xml

GROUP, OUT_OF_SIGHT = 1, 5
"""robosuite draws group 1 of the geoms and hides group 0, the collision geoms; 5 is unused."""

_ROBOT = ("robot0_", "gripper0_", "fixed_mount0_")


@functools.lru_cache(maxsize=1)  # the cameras of a scene are made one after the other
def visual_model(embodiment: str, task: str) -> Any:
    """robosuite's model with its visual geoms, without the objects that it parks elsewhere.

    Cameras share it: copy it before changing it.

    Raises:
        UnknownNameError: unknown embodiment or task.
    """
    environment = make_stock_environment(embodiment, task, hard_reset=False)
    robot = lfr.embodiments.embodiment(embodiment).robot
    spec = mujoco.MjSpec.from_string(repaired_xml(environment, robot))
    for name in lfr.tasks.task(task).unused_objects:
        spec.delete(spec.body(name))
    if robot.gripper.wrist_camera is not None:
        camera = spec.camera(STOCK_NAMES["wrist"])
        camera.pos = robot.gripper.wrist_camera.position
        camera.quat = robot.gripper.wrist_camera.quaternion
    # Multisampling takes half of a software renderer's time; at this size it is hardly seen.
    spec.visual.quality.offsamples = 0
    model = spec.compile()
    placed = environment.sim.model._model
    for i in range(1, model.nbody):  # a reset places the pictures of the target objects
        body = placed.body(model.body(i).name)
        if body.name.startswith("Visual"):
            model.body_pos[i], model.body_quat[i] = body.pos, body.quat
    return model


def coarsen_robot(model: Any, cell: float) -> None:
    """Merge the vertices of the robot's meshes within cubes of edge ``cell`` (m), in place.

    No vertex moves by more than the cube's diagonal. The triangles that remain keep the normals of
    the fine mesh, so that surfaces are shaded as they were. The task's objects stay as they are.
    """
    bodies = (model.body(body).name for body in model.geom_bodyid)
    ours = np.array([name.startswith(_ROBOT) for name in bodies])
    is_mesh = model.geom_type == mujoco.mjtGeom.mjGEOM_MESH
    for mesh in np.unique(model.geom_dataid[ours & is_mesh]):
        _coarsen(model, int(mesh), cell)


def still(model: Any) -> NDArray[np.bool_]:
    """Which geoms (ngeom,) cannot move: those of the world and of what is fastened to it."""
    return model.body_weldid[model.geom_bodyid] == 0


def transparent(model: Any) -> NDArray[np.bool_]:
    """Which geoms (ngeom,) let through what is behind them."""
    # MuJoCo: a geom without a colour of its own has its material's
    uncoloured = (model.geom_rgba == np.array([0.5, 0.5, 0.5, 1.0])).all(axis=1)
    of_material = uncoloured & (model.geom_matid >= 0)
    alpha = model.geom_rgba[:, 3].copy()
    alpha[of_material] = model.mat_rgba[model.geom_matid[of_material], 3]
    return alpha < 1.0


def in_sight(
    model: Any, data: Any, camera: int, aspect: float, group: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Which geoms of ``group`` (ngeom,) may be in the camera's picture: a bounding sphere meets it.

    Args:
        data: with the poses of geoms and cameras.
        aspect: width of the picture by its height.
    """
    axes = data.cam_xmat[camera].reshape(3, 3)
    position = (data.geom_xpos - data.cam_xpos[camera]) @ axes  # (ngeom, 3) x right, y up, -z ahead
    radius = np.where(model.geom_rbound > 0, model.geom_rbound, np.inf)  # planes are everywhere
    half_height = np.tan(0.5 * np.radians(model.cam_fovy[camera]))
    seen = group & (position[:, 2] < radius)
    for axis, slope in ((0, aspect * half_height), (1, half_height)):
        # distance to the outside of the nearer of the two side planes, of normal (1, slope)
        outside = np.abs(position[:, axis]) + slope * position[:, 2]
        seen &= outside < radius * np.hypot(1.0, slope)
    return seen


def _coarsen(model: Any, mesh: int, cell: float) -> None:
    start, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    first, vertices = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    cubes = np.floor(model.mesh_vert[first : first + vertices] / cell).astype(np.int64)
    _, chosen, cube = np.unique(cubes, axis=0, return_index=True, return_inverse=True)
    faces = chosen[cube.ravel()][model.mesh_face[start : start + count]]  # (F, 3)
    a, b, c = faces.T
    kept = np.nonzero((a != b) & (b != c) & (c != a))[0]
    end = start + len(kept)
    model.mesh_face[start:end] = faces[kept]
    model.mesh_facenormal[start:end] = model.mesh_facenormal[start + kept]
    model.mesh_facetexcoord[start:end] = model.mesh_facetexcoord[start + kept]
    model.mesh_facenum[mesh] = len(kept)
