"""Pictures of a simulation, drawn off screen with robosuite's full visual model."""

import atexit
import functools
import importlib
import os
import sys
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

import lfr.robots
import lfr.tasks
from lfr.errors import MissingLibraryError, UnknownNameError
from lfr.sim.simulation import Simulation
from lfr.sim.stock import make_stock_environment

_VISUAL_GROUP = 1
"""robosuite draws this group of geoms and hides group 0, the collision geoms."""

_SKIPPED = ("mjRND_SHADOW", "mjRND_REFLECTION", "mjRND_SKYBOX", "mjRND_HAZE")
"""Effects that cost two thirds of the time on a software renderer and show nothing of the task."""


class Camera:
    """A fixed camera on one robot's scene of a task.

    Args:
        robot, task: as for `Simulation`.
        name: a camera of robosuite's scene, such as `agentview`, `frontview` or `sideview`.
        width, height: of the picture, pixels.

    Raises:
        UnknownNameError: unknown robot, task or camera.
        MissingLibraryError: no OpenGL; names the Debian packages that bring it.
    """

    def __init__(
        self, robot: str, task: str, name: str = "agentview", width: int = 128, height: int = 128
    ) -> None:
        self.name, self.width, self.height = name, width, height
        self._model = model = _visual_model(robot, task)
        self._data = mujoco.MjData(model)
        names = tuple(model.camera(i).name for i in range(model.ncam))
        if name not in names:
            raise UnknownNameError("camera", name, names)
        self._task = lfr.tasks.task(task)
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = 0
        self._option.geomgroup[_VISUAL_GROUP] = 1
        self._option.sitegroup[:] = 0
        self._view = mujoco.MjvCamera()
        self._view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._view.fixedcamid = names.index(name)
        self._drawing = mujoco.MjvScene(model, maxgeom=1000)
        for flag in _SKIPPED:
            self._drawing.flags[getattr(mujoco.mjtRndFlag, flag)] = 0
        self._gl: Any = _opengl_context(width, height)
        self._gl.make_current()
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_resizeOffscreen(width, height, self._context)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        # Registered after EGL's own exit function, so it runs before EGL is gone.
        atexit.register(self.close)

    def render(self, simulation: Simulation) -> NDArray[np.uint8]:
        """The scene as it is now, (height, width, 3), RGB, top row first."""
        self._follow(simulation)
        mujoco.mjv_updateScene(
            self._model,
            self._data,
            self._option,
            mujoco.MjvPerturb(),
            self._view,
            mujoco.mjtCatBit.mjCAT_ALL.value,
            self._drawing,
        )
        self._gl.make_current()
        picture = np.empty((self.height, self.width, 3), dtype=np.uint8)
        frame = mujoco.MjrRect(0, 0, self.width, self.height)
        mujoco.mjr_render(frame, self._drawing, self._context)
        mujoco.mjr_readPixels(picture, None, frame, self._context)
        return picture[::-1]

    def close(self) -> None:
        """Give back the OpenGL context; it lives until the process ends otherwise."""
        atexit.unregister(self.close)
        if self._gl is not None:
            self._gl.make_current()
            self._context.free()
            self._gl.free()
            self._gl = None

    def _follow(self, simulation: Simulation) -> None:
        self._data.qpos[:] = simulation.position()
        size = simulation.cube_size()
        if size.any():
            body = self._model.body(next(iter(self._task.objects.values())))
            first = int(body.geomadr[0])
            self._model.geom_size[first : first + int(body.geomnum[0])] = size
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)


@functools.cache
def camera_available() -> bool:
    """Whether pictures can be drawn on this machine."""
    try:
        _opengl_context(1, 1).free()
    except MissingLibraryError:
        return False
    return True


def _visual_model(robot: str, task: str) -> Any:
    """robosuite's model with its visual geoms, without the objects that it parks elsewhere."""
    environment = make_stock_environment(robot, task, hard_reset=False)
    spec = mujoco.MjSpec.from_string(environment.edit_model_xml(environment.model.get_xml()))
    for name in lfr.tasks.task(task).unused_objects:
        spec.delete(spec.body(name))
    # Multisampling takes half of a software renderer's time; at this size it is hardly seen.
    spec.visual.quality.offsamples = 0
    model = spec.compile()
    placed = environment.sim.model._model
    for i in range(1, model.nbody):  # a reset places the pictures of the target objects
        body = placed.body(model.body(i).name)
        model.body_pos[i], model.body_quat[i] = body.pos, body.quat
    return model


def _opengl_context(width: int, height: int) -> Any:
    """A current-thread OpenGL context of the platform named by MUJOCO_GL (default: EGL on Linux).

    Raises:
        MissingLibraryError: the platform's library is missing or gives no context.
    """
    default = "egl" if sys.platform.startswith("linux") else "glfw"
    platform = os.environ.get("MUJOCO_GL", "").lower() or default
    try:
        return importlib.import_module(f"mujoco.{platform}").GLContext(width, height)
    # PyOpenGL reports a missing library as an attribute of None; EGL itself by the other two.
    except (ImportError, AttributeError, RuntimeError, OSError) as error:
        raise MissingLibraryError(
            f"no OpenGL for pictures (MUJOCO_GL={platform}: {error}); "
            "on Debian and Ubuntu install libegl1 and libegl-mesa0"
        ) from error
