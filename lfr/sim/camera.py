"""Pictures of a simulation, drawn off screen with robosuite's full visual model.

What a fixed camera sees of what cannot move, it draws once; a frame draws what can, and is put
together pixel by pixel, by depth. So it is what a drawing of the whole scene would be.
"""

from __future__ import annotations

import atexit
import copy
import functools
import importlib
import os
import sys
from collections.abc import Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

import lfr.tasks
from lfr.errors import MissingLibraryError, UnknownNameError
from lfr.sim.camera_params import STOCK_NAMES, CameraParams, check_names
from lfr.sim.simulation import Simulation
from lfr.sim.visual import (
    GROUP,
    OUT_OF_SIGHT,
    coarsen_robot,
    in_sight,
    still,
    transparent,
    visual_model,
)

_SKIPPED = ("mjRND_SHADOW", "mjRND_REFLECTION", "mjRND_SKYBOX", "mjRND_HAZE")
"""Effects that cost two thirds of the time on a software renderer and show nothing of the task."""

_CELL = 0.75
"""Detail of the robot's meshes, in pixels at 1 m, about the distance of robosuite's cameras."""


class Projection(NamedTuple):
    """A pinhole camera, as computer vision has it.

    Attributes:
        intrinsics: (3, 3), pixels.
        position: (3,) m, in the world.
        quaternion: (4,) wxyz, of the optical frame in the world: x right, y down, z forward.
    """

    intrinsics: NDArray[np.float64]
    position: NDArray[np.float64]
    quaternion: NDArray[np.float64]


class Camera:
    """A camera on one embodiment's scene of a task.

    Args:
        embodiment, task: as for `Simulation`.
        name, width, height: as for `CameraParams`.
        beside: a camera of this thread, whose OpenGL context draws for this one too.

    Attributes:
        moves: whether it is carried by the arm, and its pose another one at each moment.

    Raises:
        UnknownNameError: unknown embodiment or task, or no such camera in this task's scene.
        ParameterError: a size that there is not.
        MissingLibraryError: no OpenGL; names the Debian packages that bring it.
    """

    def __init__(
        self,
        embodiment: str,
        task: str,
        name: str = "agentview",
        width: int = 128,
        height: int = 128,
        beside: Camera | None = None,
    ) -> None:
        wanted = CameraParams(name, width, height)
        self.name, self.width, self.height = name, width, height
        # its own copy: what is out of sight, or too fine to be seen, differs between cameras
        self._model = model = copy.copy(visual_model(embodiment, task))
        self._data = mujoco.MjData(model)
        there = {model.camera(i).name: i for i in range(model.ncam)}
        if (camera := there.get(STOCK_NAMES[wanted.name])) is None:
            known = [name for name, stock in STOCK_NAMES.items() if stock in there]
            raise UnknownNameError(f"camera of {task}", name, known)
        self.moves = bool(model.body_weldid[model.cam_bodyid[camera]])
        if model.cam_bodyid[camera] == 0:  # one on the arm looks from nearby
            pixel = 2.0 * np.tan(0.5 * np.radians(model.cam_fovy[camera])) / height
            coarsen_robot(model, _CELL * pixel)
        self._visual = model.geom_group == GROUP
        self._each_time = self._visual.copy()  # what a frame draws
        self._still: tuple[NDArray[np.uint8], NDArray[np.float32]] | None = None
        if not self.moves:
            # what is transparent hides nothing: it is drawn over whatever the frame has behind it
            self._each_time &= ~still(model) | transparent(model)
        self._task = lfr.tasks.task(task)
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = 0
        self._option.geomgroup[GROUP] = 1
        self._option.sitegroup[:] = 0
        self._view = mujoco.MjvCamera()
        self._view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._view.fixedcamid = camera
        self._drawing = mujoco.MjvScene(model, maxgeom=1000)
        for flag in _SKIPPED:
            self._drawing.flags[getattr(mujoco.mjtRndFlag, flag)] = 0
        self._gl: Any = (beside and beside._gl) or _opengl_context(width, height)
        self._gl.make_current()
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_resizeOffscreen(width, height, self._context)
        # Registered after EGL's own exit function, so it runs before EGL is gone.
        atexit.register(self.close)

    def render(self, simulation: Simulation) -> NDArray[np.uint8]:
        """The scene as it is now, (height, width, 3), RGB, top row first."""
        self._follow(simulation)
        picture, depth = self._draw(self._each_time)
        if self.moves:
            return picture[::-1]
        if self._still is None:
            alike = self._visual & still(self._model)
            _, behind = self._draw(alike & ~transparent(self._model))
            self._still = self._draw(alike)[0], behind
        background, behind = self._still
        return np.where((depth < behind)[..., None], picture, background)[::-1]

    def projection(self, simulation: Simulation) -> Projection:
        """How points in the world fall on its picture of the scene as it is now."""
        self._pose(simulation)
        model, data, camera = self._model, self._data, self._view.fixedcamid
        focal = 0.5 * self.height / np.tan(0.5 * np.radians(model.cam_fovy[camera]))
        centre = [0.5 * self.width, 0.5 * self.height]
        intrinsics = np.array([[focal, 0.0, centre[0]], [0.0, focal, centre[1]], [0.0, 0.0, 1.0]])
        # MuJoCo's camera looks along its -z axis, with y up.
        axes = data.cam_xmat[camera].reshape(3, 3) * [1.0, -1.0, -1.0]
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(axes).ravel())
        return Projection(intrinsics, data.cam_xpos[camera].copy(), quaternion)

    def close(self) -> None:
        """Give back what it draws with, which lives until the process ends otherwise."""
        atexit.unregister(self.close)
        if self._gl is not None:
            self._gl.make_current()
            self._context.free()
            self._gl = None  # MuJoCo frees a context that no camera has any more

    def _draw(self, geoms: NDArray[np.bool_]) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Picture and depth, bottom row first, of those of ``geoms`` (ngeom,) that are in sight.

        A depth is from 0, near, to 1, and 1 where nothing is; what is transparent has none.
        """
        model, aspect = self._model, self.width / self.height
        seen = geoms & in_sight(model, self._data, self._view.fixedcamid, aspect, geoms)
        model.geom_group[self._visual] = np.where(seen[self._visual], GROUP, OUT_OF_SIGHT)
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(
            model, self._data, self._option, mujoco.MjvPerturb(), self._view, everything,
            self._drawing,
        )  # fmt: skip
        self._gl.make_current()
        picture = np.empty((self.height, self.width, 3), dtype=np.uint8)
        depth = np.empty((self.height, self.width), dtype=np.float32)
        frame = mujoco.MjrRect(0, 0, self.width, self.height)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        mujoco.mjr_render(frame, self._drawing, self._context)
        mujoco.mjr_readPixels(picture, depth, frame, self._context)
        return picture, depth

    def _pose(self, simulation: Simulation) -> None:
        self._data.qpos[:] = simulation.position()
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)

    def _follow(self, simulation: Simulation) -> None:
        self._pose(simulation)
        size = simulation.cube_size()
        if size.any():
            body = self._model.body(next(iter(self._task.objects.values())))
            first = int(body.geomadr[0])
            last = first + int(body.geomnum[0])
            self._model.geom_size[first:last] = size
            self._model.geom_rbound[first:last] = np.linalg.norm(size)


def open_cameras(embodiment: str, task: str, wanted: Sequence[CameraParams]) -> tuple[Camera, ...]:
    """Several cameras on one scene, in this order, which share an OpenGL context.

    Raises:
        ParameterError: two of the same name; otherwise as `Camera`.
    """
    check_names(wanted)
    cameras: list[Camera] = []
    for one in wanted:
        first = cameras[0] if cameras else None
        cameras.append(Camera(embodiment, task, one.name, one.width, one.height, first))
    return tuple(cameras)


@functools.cache
def camera_available() -> bool:
    """Whether pictures can be drawn on this machine."""
    try:
        _opengl_context(1, 1).free()
    except MissingLibraryError:
        return False
    return True


def _opengl_context(width: int, height: int) -> Any:
    """A current-thread OpenGL context of the platform named by MUJOCO_GL (default: EGL on Linux).

    Raises:
        MissingLibraryError: the platform's library is missing or gives no context.
    """
    default = "egl" if sys.platform.startswith("linux") else "glfw"
    platform = os.environ.get("MUJOCO_GL", "").lower() or default
    # Mesa's software renderer would start threads beside the one of each job.
    os.environ.setdefault("LP_NUM_THREADS", "0")
    try:
        return importlib.import_module(f"mujoco.{platform}").GLContext(width, height)
    # PyOpenGL reports a missing library as an attribute of None; EGL itself by the other two.
    except (ImportError, AttributeError, RuntimeError, OSError) as error:
        raise MissingLibraryError(
            f"no OpenGL for pictures (MUJOCO_GL={platform}: {error}); "
            "on Debian and Ubuntu install libegl1 and libegl-mesa0"
        ) from error
