"""What the bodies of a MuJoCo model look like: their visual geoms as arrays in the body's frame."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import mujoco

VISUAL_GROUP = 1
"""robosuite's group of visual geoms; 0 holds collision geoms, 2 controller markers."""

UNSET_RGBA = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's default `rgba`: a geom that still has it takes its material's colour."""


@dataclass(frozen=True)
class Mesh:
    """Triangles in the body's frame (m), coloured by vertex or by a texture.

    Attributes:
        positions: (V, 3) float32.
        normals: (V, 3) float32, unit length.
        triangles: (F, 3) uint32, indices of vertices.
        colors: (V, 4) uint8 RGBA; white where a texture gives the colour.
        texcoords: (V, 2) float32, or None without a texture.
        texture: (height, width, 3) uint8, or None.
    """

    positions: NDArray[np.float32]
    normals: NDArray[np.float32]
    triangles: NDArray[np.uint32]
    colors: NDArray[np.uint8]
    texcoords: NDArray[np.float32] | None = None
    texture: NDArray[np.uint8] | None = None


@dataclass(frozen=True)
class Solid:
    """A primitive geom in the body's frame.

    Attributes:
        kind: "box", "cylinder", "capsule" or "ellipsoid".
        center: (3,) m.
        quaternion: (4,) xyzw, as rerun orders it.
        size: (3,) m: half extents; radius, half length and 0 of a cylinder or capsule.
        color: (4,) uint8 RGBA.
    """

    kind: str
    center: NDArray[np.float64]
    quaternion: NDArray[np.float64]
    size: NDArray[np.float64]
    color: NDArray[np.uint8]


@dataclass(frozen=True)
class Body:
    """A body with something to see: one mesh of all its plain parts, textured ones, primitives.

    `fixed` bodies never move; their pose in the world is `position` (3,) m and `quaternion` (4,)
    wxyz.
    """

    name: str
    fixed: bool
    position: NDArray[np.float64]
    quaternion: NDArray[np.float64]
    meshes: tuple[Mesh, ...]
    solids: tuple[Solid, ...]


def visible_bodies(
    model: mujoco.MjModel, data: mujoco.MjData, hidden: Collection[str] = ()
) -> tuple[Body, ...]:
    """Every body with visual geoms, except the world (floor and walls) and those `hidden`.

    Args:
        model: the model with its visual geoms.
        data: its state after `mj_kinematics`, for the poses of fixed bodies.
        hidden: names of bodies to leave out.
    """
    bodies = []
    for index in range(1, model.nbody):
        first = int(model.body_geomadr[index])
        geoms = [
            geom
            for geom in range(first, first + int(model.body_geomnum[index]))
            if model.geom_group[geom] == VISUAL_GROUP
        ]
        name = model.body(index).name
        if not geoms or name in hidden:
            continue
        bodies.append(
            Body(
                name=name,
                fixed=bool(model.body_weldid[index] == 0),
                position=data.xpos[index].copy(),
                quaternion=data.xquat[index].copy(),
                meshes=_meshes(model, geoms),
                solids=_solids(model, geoms),
            )
        )
    return tuple(bodies)


def _meshes(model: mujoco.MjModel, geoms: list[int]) -> tuple[Mesh, ...]:
    import mujoco

    parts = [_mesh(model, g) for g in geoms if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_MESH]
    plain = [part for part in parts if part.texture is None]
    textured = [part for part in parts if part.texture is not None]
    # One entity per body instead of up to 17: the tree stays readable and the viewer quick.
    return tuple([_merged(plain), *textured] if plain else textured)


def _merged(parts: list[Mesh]) -> Mesh:
    starts = np.cumsum([0, *(len(part.positions) for part in parts)])
    triangles = [part.triangles + start for part, start in zip(parts, starts, strict=False)]
    return Mesh(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate(triangles).astype(np.uint32),
        np.concatenate([part.colors for part in parts]),
    )


def _mesh(model: mujoco.MjModel, geom: int) -> Mesh:
    mesh = int(model.geom_dataid[geom])
    faces = slice(model.mesh_faceadr[mesh], model.mesh_faceadr[mesh] + model.mesh_facenum[mesh])
    corners = model.mesh_face[faces]  # (F, 3), as the two below
    corner_normals = model.mesh_facenormal[faces]
    corner_texcoords = model.mesh_facetexcoord[faces]
    texture = _texture(model, geom)
    wraps = texture is not None and model.mesh_texcoordadr[mesh] >= 0
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :]
    normals = model.mesh_normal[model.mesh_normaladr[mesh] :]
    keys = np.stack([corners, corner_normals, corner_texcoords * wraps], axis=-1).reshape(-1, 3)
    # A vertex of rerun is a triple that MuJoCo keeps apart: position, normal, texture coordinate.
    unique, triangles = np.unique(keys, axis=0, return_inverse=True)
    rotation = _rotation(model.geom_quat[geom])
    texcoords = None
    if wraps:
        texcoords = model.mesh_texcoord[model.mesh_texcoordadr[mesh] :][unique[:, 2]]
    color = np.full(4, 255, np.uint8) if wraps else _color(model, geom)
    return Mesh(
        positions=(vertices[unique[:, 0]] @ rotation.T + model.geom_pos[geom]).astype(np.float32),
        normals=(normals[unique[:, 1]] @ rotation.T).astype(np.float32),
        triangles=triangles.reshape(-1, 3).astype(np.uint32),
        colors=np.tile(color, (len(unique), 1)),
        texcoords=texcoords,
        texture=texture if wraps else None,
    )


def _solids(model: mujoco.MjModel, geoms: list[int]) -> tuple[Solid, ...]:
    import mujoco

    kinds = {
        mujoco.mjtGeom.mjGEOM_BOX: "box",
        mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
        mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
        mujoco.mjtGeom.mjGEOM_ELLIPSOID: "ellipsoid",
        mujoco.mjtGeom.mjGEOM_SPHERE: "ellipsoid",
    }
    solids = []
    for geom in geoms:
        shape = mujoco.mjtGeom(int(model.geom_type[geom]))
        if shape in kinds:
            size = model.geom_size[geom].copy()
            if shape == mujoco.mjtGeom.mjGEOM_SPHERE:
                size[:] = size[0]
            quaternion = np.roll(model.geom_quat[geom], -1)
            center = model.geom_pos[geom].copy()
            solids.append(Solid(kinds[shape], center, quaternion, size, _color(model, geom)))
    return tuple(solids)


def _color(model: mujoco.MjModel, geom: int) -> NDArray[np.uint8]:
    """RGBA of a geom: its own colour or its material's, times the mean of its texture."""
    rgba, material = model.geom_rgba[geom].astype(np.float64), int(model.geom_matid[geom])
    if material >= 0 and np.allclose(rgba, UNSET_RGBA):
        rgba = model.mat_rgba[material].astype(np.float64)
    texture = _texture(model, geom)
    if texture is not None:
        rgba[:3] *= texture.reshape(-1, 3).mean(axis=0) / 255
    return np.round(rgba * 255).astype(np.uint8)


def _texture(model: mujoco.MjModel, geom: int) -> NDArray[np.uint8] | None:
    material = int(model.geom_matid[geom])
    used = [] if material < 0 else [int(t) for t in model.mat_texid[material] if t >= 0]
    if not used:
        return None
    height, width, channels = (
        int(array[used[0]]) for array in (model.tex_height, model.tex_width, model.tex_nchannel)
    )
    start = int(model.tex_adr[used[0]])
    pixels = model.tex_data[start : start + height * width * channels]
    return pixels.reshape(height, width, channels)[:, :, :3].copy()


def _rotation(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    import mujoco

    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)
