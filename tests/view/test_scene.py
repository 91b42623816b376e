"""The static geometry against the model that robosuite builds."""

import mujoco
import numpy as np
import pytest

from lfr.sim.stock import make_stock_environment
from lfr.view.geometry import visible_bodies
from lfr.view.scene import SCENE, scene_folder

from . import rrd


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    environment = make_stock_environment("panda", "lift", hard_reset=True)
    environment.reset()
    return environment.sim.model._model


def test_every_body_with_visual_meshes_is_one_mesh_entity(model: mujoco.MjModel) -> None:
    mesh = mujoco.mjtGeom.mjGEOM_MESH
    visual = [g for g in range(model.ngeom) if model.geom_group[g] == 1]
    faces: dict[str, int] = {}
    for geom in (g for g in visual if model.geom_type[g] == mesh):
        body = model.body(model.geom_bodyid[geom]).name
        faces[body] = faces.get(body, 0) + int(model.mesh_facenum[model.geom_dataid[geom]])
    entities = rrd.read(scene_folder("panda", "lift") / SCENE)
    found = {
        path.split("/")[2]: len(components["Mesh3D:triangle_indices"][1][0])
        for path, components in entities.items()
        if "Mesh3D:triangle_indices" in components
    }
    assert found == faces  # no collision geom among them: it would add faces or bodies


def test_a_mesh_stands_where_mujoco_has_it(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for body in visible_bodies(model, data):
        index = model.body(body.name).id
        rotation, position = data.xmat[index].reshape(3, 3), data.xpos[index]
        first = int(model.body_geomadr[index])
        boxes = [
            _bounds(model, data, geom)
            for geom in range(first, first + int(model.body_geomnum[index]))
            if model.geom_group[geom] == 1 and model.geom_dataid[geom] >= 0
        ]
        if boxes:
            vertices = np.concatenate([m.positions for m in body.meshes]) @ rotation.T + position
            low = np.min([box[0] for box in boxes], axis=0)
            high = np.max([box[1] for box in boxes], axis=0)
            np.testing.assert_allclose([vertices.min(0), vertices.max(0)], [low, high], atol=1e-5)


def _bounds(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> tuple[np.ndarray, np.ndarray]:
    """Extent in the world of a geom's raw vertices, through MuJoCo's own geom pose."""
    mesh = model.geom_dataid[geom]
    start, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    local = model.mesh_vert[start : start + count]
    world = local @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
    return world.min(axis=0), world.max(axis=0)


def test_only_bodies_that_never_move_have_a_static_pose(model: mujoco.MjModel) -> None:
    entities = rrd.read(scene_folder("panda", "lift") / SCENE)
    posed = {path.split("/")[2] for path, c in entities.items() if "Transform3D:translation" in c}
    assert "table" in posed
    assert not posed & {"cube_main", "robot0_link1", "gripper0_right_leftfinger"}
    assert all(model.body_weldid[model.body(name).id] == 0 for name in posed)
