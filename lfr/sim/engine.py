"""All that the kernel needs of one simulation, as one object.

Compiled code takes its arguments apart at every call, each array by itself: some 40 of them cost
more than a reset. A numba struct holds them on the compiled side and is passed as one pointer.
"""

from typing import Any

from numba import types
from numba.experimental import structref

from lfr.compiled.arrays import Control, Physics, SceneArrays
from lfr.sim.compilation import entry
from lfr.sim.cube import Cube
from lfr.sim.start import Drawn, StartArrays

_FIELDS = ["physics", "scene", "control", "start", "drawn", "cube"]


@structref.register
class _EngineType(types.StructRef):
    def preprocess_fields(self, fields: Any) -> Any:
        return tuple((name, types.unliteral(kind)) for name, kind in fields)


class Engine(structref.StructRefProxy):
    """See `engine`; to Python it is opaque."""

    physics: Physics
    scene: SceneArrays
    control: Control
    start: StartArrays
    drawn: Drawn
    cube: Cube


structref.define_constructor(Engine, _EngineType, _FIELDS)
structref.define_boxing(_EngineType, Engine)


@entry
def engine(
    physics: Physics,
    scene: SceneArrays,
    control: Control,
    start: StartArrays,
    drawn: Drawn,
    cube: Cube,
) -> Engine:
    """Bind the parts; they are shared, not copied. Whoever owns the physics must outlive it."""
    return Engine(physics, scene, control, start, drawn, cube)
