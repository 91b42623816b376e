"""Lift's cube at other sizes against MuJoCo's constants; the shared model stays whole."""

import copy

import mujoco
import numpy as np
import pytest

from lfr.errors import LfrError
from lfr.sim import cube
from lfr.sim.cube import ResizableModel, resize
from lfr.sim.scene_cache import load_scene

SIZE = np.array([0.0213, 0.0217, 0.0205])


def remade(model: mujoco.MjModel, size: np.ndarray) -> mujoco.MjModel:
    """`model` with a cube of this size, all that follows from it found by `mj_setConst`."""
    other = copy.copy(model)
    body, geom = other.body("cube_main"), other.geom("cube_g0").id
    density = body.mass[0] / np.prod(other.geom_size[geom])
    body.mass[0] = density * np.prod(size)
    body.inertia[:] = body.mass[0] / 3 * ((size**2).sum() - size**2)
    other.geom_size[geom], other.geom_rbound[geom] = size, np.linalg.norm(size)
    other.geom_aabb[geom, 3:] = other.bvh_aabb[other.body_bvhadr[body.id], 3:] = size
    mujoco.mj_setConst(other, mujoco.MjData(other))
    return other


@pytest.mark.parametrize("robot", ["panda", "sawyer"])
def test_what_depends_on_the_size_is_what_mujoco_finds(robot: str) -> None:
    model = load_scene(robot, "lift").model
    before = {name: np.array(getattr(model, name)) for name in cube._OWNED}
    own = ResizableModel(model, "cube_main")
    resize(own.cube, SIZE)
    expected = remade(model, SIZE)
    for name in cube._OWNED:
        np.testing.assert_allclose(own.arrays[name], getattr(expected, name), rtol=1e-12)
    assert own.cube.mean_inertia[0] == pytest.approx(expected.stat.meaninertia, rel=1e-12)
    # Nothing else of a model depends on it, but two means that only pictures use.
    for name in (name for name in dir(model) if not name.startswith("_")):
        array = getattr(model, name)
        if isinstance(array, np.ndarray) and name not in cube._OWNED:
            np.testing.assert_array_equal(array, getattr(expected, name), err_msg=name)
    for name, value in before.items():  # the shared model is as it was
        np.testing.assert_array_equal(getattr(model, name), value)
    resize(own.cube, model.geom_size[model.geom("cube_g0").id])
    for name, value in before.items():
        np.testing.assert_allclose(own.arrays[name], value, rtol=1e-12)


def test_simulations_with_cubes_of_their_own_do_not_disturb_each_other() -> None:
    from lfr.sim.simulation import Simulation

    alone = Simulation("panda", "lift")
    alone.reset(1)
    actions = np.random.default_rng(0).uniform(-1, 1, (30, 7))
    expected = alone.step(actions).observations
    one, other = Simulation("panda", "lift"), Simulation("panda", "lift")
    one.reset(1)
    other.reset(2)
    assert not np.allclose(one.cube_size(), other.cube_size())
    np.testing.assert_array_equal(one.step(actions).observations, expected)


def test_an_unknown_model_layout_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    found = cube._offsets()
    wrong = found | {"geom_size": found["geom_size"] + 8}
    monkeypatch.setattr(cube, "_offsets", lambda: wrong)
    with pytest.raises(LfrError, match="geom_size in an unknown place"):
        ResizableModel(load_scene("panda", "lift").model, "cube_main")
