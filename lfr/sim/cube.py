"""Lift's cube, whose size differs from episode to episode: what of a MuJoCo model depends on it.

robosuite compiles a new model for each size. Here a simulation owns the few arrays that the size
enters and shares all others with its scene's model; a new size is written into them in closed form,
as `mj_setConst` would find it for a free body with its origin at its centre.
"""

import ctypes
import functools
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from lfr.compiled import compiled
from lfr.errors import LfrError

_OWNED = (
    *("body_mass", "body_inertia", "body_invweight0", "body_subtreemass"),
    *("dof_M0", "dof_invweight0", "dof_length"),
    *("geom_size", "geom_rbound", "geom_aabb", "bvh_aabb"),
)


class Cube(NamedTuple):
    """Views of the owned arrays, of the cube alone; empty ones where no cube is resized.

    `built` are the values that the model was compiled with.
    """

    density: float  # kg per product of half sizes
    others_mass: float  # kg, of all other bodies
    others_inertia: float  # diagonal of M at qpos0, summed over all other dofs
    dofs: int  # of the whole model
    mean_inertia: NDArray[np.float64]  # (1,)
    mass: NDArray[np.float64]  # (1,)
    total_mass: NDArray[np.float64]  # (1,)
    inertia: NDArray[np.float64]  # (3,)
    inverse_weight: NDArray[np.float64]  # (2,)
    subtree_mass: NDArray[np.float64]  # (1,)
    dof_inertia: NDArray[np.float64]  # (6,)
    dof_inverse_weight: NDArray[np.float64]  # (6,)
    dof_length: NDArray[np.float64]  # (6,)
    size: NDArray[np.float64]  # (3,) half sizes
    radius: NDArray[np.float64]  # (1,)
    box: NDArray[np.float64]  # (3,)
    tree_box: NDArray[np.float64]  # (3,)


@compiled
def resize(cube: Cube, size: NDArray[np.float64]) -> None:
    """Give the cube other half sizes (3,), m."""
    product, squares = 1.0, 0.0
    for i in range(3):
        product *= size[i]
        squares += size[i] ** 2
    mass, radius = cube.density * product, np.sqrt(squares)
    inverse, inertia = 0.0, 0.0
    for i in range(3):
        cube.size[i] = cube.box[i] = cube.tree_box[i] = size[i]
        cube.inertia[i] = mass / 3.0 * (squares - size[i] ** 2)
        inertia += cube.inertia[i]
        inverse += 1.0 / cube.inertia[i] / 3.0
    cube.mass[0] = cube.subtree_mass[0] = mass
    cube.total_mass[0] = cube.others_mass + mass
    cube.radius[0] = radius
    cube.inverse_weight[0], cube.inverse_weight[1] = 1.0 / mass, inverse
    for i in range(3):
        cube.dof_inertia[i], cube.dof_inertia[3 + i] = mass, cube.inertia[i]
        cube.dof_inverse_weight[i], cube.dof_inverse_weight[3 + i] = 1.0 / mass, inverse
        cube.dof_length[3 + i] = radius
    cube.mean_inertia[0] = (cube.others_inertia + 3.0 * mass + inertia) / cube.dofs


def no_cube() -> Cube:
    """Where nothing is resized."""
    return Cube(0.0, 0.0, 0.0, 1, *(np.zeros(0) for _ in range(len(Cube._fields) - 4)))


class ResizableModel:
    """A model that shares its arrays with `model`, but those that the size of `body` enters.

    Attributes:
        address: of the C struct; valid as long as this object and `model` live.
        arrays: the owned arrays, by their names in MjModel.
        cube: the views that `resize` writes through.

    Raises:
        LfrError: a libmujoco that lays out its model in an unknown way.
    """

    def __init__(self, model: mujoco.MjModel, body: str) -> None:
        self._shared = model
        self._struct = _words(model._address, _struct_size()).copy()
        self.address = self._struct.ctypes.data
        self.arrays = {name: np.array(getattr(model, name)) for name in _OWNED}
        for name, offset in _offsets().items():
            if self._struct[offset // 8] != getattr(model, name).ctypes.data:
                raise LfrError(f"libmujoco {mujoco.__version__} keeps {name} in an unknown place")
            self._struct[offset // 8] = self.arrays[name].ctypes.data
        self.cube = self._cube(model, model.body(body))

    def _cube(self, model: mujoco.MjModel, body: Any) -> Cube:
        own, i = self.arrays, body.id
        geom, node = int(body.geomadr[0]), int(model.body_bvhadr[i])
        first = int(model.jnt_dofadr[body.jntadr[0]])
        dofs = slice(first, first + 6)
        statistics = self._struct.view(np.float64)[_mean_inertia_offset(model) // 8 :]
        return Cube(
            density=float(model.body_mass[i] / np.prod(model.geom_size[geom])),
            others_mass=float(model.body_subtreemass[0] - model.body_mass[i]),
            others_inertia=float(model.dof_M0.sum() - model.dof_M0[dofs].sum()),
            dofs=model.nv,
            mean_inertia=statistics[:1],
            mass=own["body_mass"][i : i + 1],
            total_mass=own["body_subtreemass"][:1],
            inertia=own["body_inertia"][i],
            inverse_weight=own["body_invweight0"][i],
            subtree_mass=own["body_subtreemass"][i : i + 1],
            dof_inertia=own["dof_M0"][dofs],
            dof_inverse_weight=own["dof_invweight0"][dofs],
            dof_length=own["dof_length"][dofs],
            size=own["geom_size"][geom],
            radius=own["geom_rbound"][geom : geom + 1],
            box=own["geom_aabb"][geom, 3:],
            tree_box=own["bvh_aabb"][node, 3:],
        )


@functools.cache
def _offsets() -> dict[str, int]:
    """Byte offsets of the owned arrays' pointers in mjModel, found in a small model."""
    model = _small()
    words = _words(model._address, _struct_size())
    places = {}
    for name in _OWNED:
        found = np.flatnonzero(words == getattr(model, name).ctypes.data)
        if len(found) != 1:
            raise LfrError(
                f"libmujoco {mujoco.__version__} lays out its model in an unknown way ({name} in "
                f"{len(found)} places, expected one); install the locked environment"
            )
        places[name] = 8 * int(found[0])
    return places


@functools.cache
def _struct_size() -> int:
    """Bytes of mjModel: up to its last pointer into the buffer, and the signature behind it."""
    model = _small()
    numbers, word = model.opt.gravity.ctypes.data, 8  # inside the struct, before the pointers
    place = numbers - numbers % word
    while _words(place, word)[0] != model.qpos0.ctypes.data:
        place += word
    first = int(_words(place, word)[0])  # the buffer, which begins with qpos0
    while first <= _words(place, word)[0] <= first + model.nbuffer:
        place += word
    return place - model._address + word


def _mean_inertia_offset(model: mujoco.MjModel) -> int:
    """Of `stat.meaninertia`, four numbers before `stat.center`, inside the struct."""
    offset = model.stat.center.ctypes.data - model._address - 32
    if _words(model._address + offset, 8).view(np.float64)[0] != model.stat.meaninertia:
        raise LfrError(f"libmujoco {mujoco.__version__} keeps its statistics in an unknown place")
    return offset


def _small() -> mujoco.MjModel:
    box = '<body><freejoint/><geom type="box" size=".1 .2 .3"/></body>'
    return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{box}{box}</worldbody></mujoco>")


def _words(address: int, size: int) -> NDArray[np.uint64]:
    return np.ctypeslib.as_array((ctypes.c_uint64 * (size // 8)).from_address(address))
