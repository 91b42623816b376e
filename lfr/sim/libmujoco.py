"""MuJoCo's own C functions and structs, as the compiled kernel sees them.

The kernel calls `mj_step1`, `mj_step2` and a few others by their symbols and reads MjData
through NumPy views. All views but two come from the Python bindings; the number of contacts and the
contact array have no fixed view there, so their places in the struct are found by experiment, once
per process, and a struct that does not answer as expected is an error, never wrong physics.
"""

import ctypes
import functools
from pathlib import Path
from typing import NamedTuple

import llvmlite.binding
import mujoco
import numpy as np
from numba import types
from numpy.typing import NDArray

from lfr.compiled.arrays import Physics
from lfr.compiled.contacts import MAX_CONTACTS
from lfr.errors import LfrError

CHECKED_VERSIONS = ("3.8.", "3.9.")
"""MuJoCo releases whose functions have the signatures below."""

_POINTER = types.intp
_STEP_SIGNATURE = types.void(_POINTER, _POINTER)
mj_step1 = types.ExternalFunction("mj_step1", _STEP_SIGNATURE)
mj_step2 = types.ExternalFunction("mj_step2", _STEP_SIGNATURE)
mj_resetData = types.ExternalFunction("mj_resetData", _STEP_SIGNATURE)
mj_kinematics = types.ExternalFunction("mj_kinematics", _STEP_SIGNATURE)


class _ContactLayout(NamedTuple):
    count_offset: int  # of mjData.ncon, from mjData.energy
    geom_offset: int  # of mjContact.geom, from the start of the arena's first contact
    stride: int  # sizeof(mjContact)


def load() -> None:
    """Make libmujoco's symbols visible to compiled code.

    Raises:
        LfrError: no library of a checked version.
    """
    if not mujoco.__version__.startswith(CHECKED_VERSIONS):
        raise LfrError(
            f"MuJoCo {mujoco.__version__} found, but the simulation kernel was checked against "
            f"{', '.join(version + 'x' for version in CHECKED_VERSIONS)} only; "
            "install the locked environment (make setup)"
        )
    folder = Path(mujoco.__file__).parent
    names = ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll")
    libraries = sorted(path for name in names for path in folder.glob(name))
    if not libraries:
        raise LfrError(f"no libmujoco found in {folder}, expected one of {', '.join(names)}")
    llvmlite.binding.load_library_permanently(str(libraries[0]))


def physics(model: mujoco.MjModel, data: mujoco.MjData, address: int | None = None) -> Physics:
    """Views of `data` for the kernel; they stay valid as long as `data` lives.

    `address` is that of another mjModel of the same shape, to be used instead of `model`'s own.
    """
    layout = _contact_layout()
    count = _integers(_energy(data) + layout.count_offset, 1)
    # The contact array starts the arena, and the arena never moves.
    first = _first_contact(model, data)
    flat = _integers(first, MAX_CONTACTS * layout.stride // 4)
    geoms = flat.reshape(MAX_CONTACTS, layout.stride // 4)[:, :2]
    return Physics(
        model=model._address if address is None else address,
        data=data._address,
        qpos=data.qpos,
        qvel=data.qvel,
        ctrl=data.ctrl,
        bias=data.qfrc_bias,
        inertia=data.qM,
        xanchor=data.xanchor,
        xaxis=data.xaxis,
        xpos=data.xpos,
        xmat=data.xmat,
        geom_xpos=data.geom_xpos,
        site_xpos=data.site_xpos,
        site_xmat=data.site_xmat,
        contact_count=count,
        contact_geoms=geoms,
    )


def _integers(address: int, size: int) -> NDArray[np.int32]:
    return np.ctypeslib.as_array((ctypes.c_int32 * size).from_address(address))


def _energy(data: mujoco.MjData) -> int:
    """Address of mjData.energy, an array inside the struct, close behind mjData.ncon."""
    return data.energy.ctypes.data


def _first_contact(model: mujoco.MjModel, data: mujoco.MjData) -> int:
    """Address of the first contact's geom pair."""
    if data.ncon == 0:
        pointer = ctypes.c_void_p.from_address(_energy(data) + 24).value  # buffer, then arena
        return (pointer or 0) + _contact_layout().geom_offset
    return data.contact.geom.ctypes.data


@functools.cache
def _contact_layout() -> _ContactLayout:
    """Find `ncon` and the contact array where 1 to 5 spheres lie on a plane."""
    candidates: set[int] | None = None
    geom_offsets, strides = set(), set()
    for count in (2, 1, 5, 3):
        model, data = _spheres(count)
        mujoco.mj_forward(model, data)
        energy = _energy(data)
        values = _integers(energy - 160, 40)
        matches = {4 * int(i) - 160 for i in np.flatnonzero(values == count)}
        candidates = matches if candidates is None else candidates & matches
        arena = ctypes.c_void_p.from_address(energy + 24).value or 0
        geom_offsets.add(data.contact.geom.ctypes.data - arena)
        if count > 1:
            strides.add(data.contact.geom.strides[0])
    if candidates is None or len(candidates) != 1 or len(geom_offsets) != 1 or len(strides) != 1:
        raise LfrError(
            f"libmujoco {mujoco.__version__} lays out its contacts in an unknown way "
            f"(ncon at {sorted(candidates or ())}, geoms at {sorted(geom_offsets)}, "
            f"stride {sorted(strides)}; expected one of each); install the locked environment"
        )
    return _ContactLayout(candidates.pop(), geom_offsets.pop(), strides.pop())


def _spheres(count: int) -> tuple[mujoco.MjModel, mujoco.MjData]:
    # All on one body, so that the numbers of bodies and of contact islands stay the same.
    spheres = "".join(f'<geom size=".1" pos="{i} 0 0"/>' for i in range(count))
    body = f'<body pos="0 0 .09"><freejoint/>{spheres}</body>'
    xml = f'<mujoco><worldbody><geom type="plane" size="9 9 1"/>{body}</worldbody></mujoco>'
    model = mujoco.MjModel.from_xml_string(xml)
    return model, mujoco.MjData(model)
