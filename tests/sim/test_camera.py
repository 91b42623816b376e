"""Pictures; only where OpenGL is installed, and the message where it is not."""

import mujoco
import numpy as np
import pytest

from lfr.errors import MissingLibraryError, UnknownNameError
from lfr.sim import camera
from lfr.sim.camera import Camera, camera_available
from lfr.sim.simulation import simulation
from tests.sim.pairs import put

needs_opengl = pytest.mark.skipif(not camera_available(), reason="no OpenGL (libegl1)")


@needs_opengl
@pytest.mark.parametrize("task", ["lift", "pick_place"])
def test_the_picture_follows_the_simulation(task: str) -> None:
    engine, view = simulation("panda", task), Camera("panda", task)
    engine.reset(0)
    first = view.render(engine)
    assert first.shape == (128, 128, 3)
    assert first.dtype == np.uint8
    np.testing.assert_array_equal(first, view.render(engine))
    red = (first[..., 0] > 90) & (first[..., 0] > 2 * first[..., 1].astype(int))
    assert red.sum() > 15, "the red object is not in the picture"
    columns = np.nonzero(red)[1]
    position = engine._data.body(next(iter(engine.task.objects.values()))).xpos.copy()
    # the agent's view looks along -x: +y is to the right
    put(engine, np.array([*(position + np.array([0, 0.1, 0.02])), 1, 0, 0, 0]))
    moved = view.render(engine)
    red = (moved[..., 0] > 90) & (moved[..., 0] > 2 * moved[..., 1].astype(int))
    assert np.nonzero(red)[1].mean() > columns.mean() + 5
    view.close()
    view.close()


@needs_opengl
@pytest.mark.parametrize(("width", "height"), [(128, 128), (160, 96)])
def test_the_projection_tells_where_a_point_is_in_the_picture(width: int, height: int) -> None:
    engine, view = simulation("panda", "lift"), Camera("panda", "lift", "agentview", width, height)
    engine.reset(0)
    picture = view.render(engine).astype(int)
    red = (picture[..., 0] > 90) & (picture[..., 0] > 2 * picture[..., 1])
    row, column = (places.mean() for places in np.nonzero(red))
    intrinsics, position, quaternion = view.projection()
    axes = np.empty(9)
    mujoco.mju_quat2Mat(axes, quaternion)
    cube, _ = engine.body_poses()["cube_main"]
    ray = intrinsics @ axes.reshape(3, 3).T @ (cube - position)
    assert ray[2] > 0  # in front of the camera
    assert ray[:2] / ray[2] == pytest.approx([column + 0.5, row + 0.5], abs=2.0)
    view.close()


@needs_opengl
def test_an_unknown_camera_lists_the_cameras() -> None:
    with pytest.raises(UnknownNameError, match="agentview"):
        Camera("panda", "lift", name="agent")


def test_missing_opengl_names_the_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "nonesuch")
    with pytest.raises(MissingLibraryError, match="libegl1 and libegl-mesa0"):
        camera._opengl_context(8, 8)


@needs_opengl
@pytest.mark.parametrize("task", ["lift", "nut_assembly"])
def test_what_is_left_out_is_not_in_the_picture(task: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against every geom drawn, and against every triangle drawn, while the arm moves about."""
    engine = simulation("sawyer", task)
    engine.reset(3)
    view = Camera("sawyer", task)
    monkeypatch.setattr(camera, "coarsen_robot", lambda *_: None)
    fine = Camera("sawyer", task)
    assert view._model.mesh_facenum.sum() < 0.5 * fine._model.mesh_facenum.sum()
    for action in np.random.default_rng(0).uniform(-1, 1, (8, 7)):
        engine.step(np.tile(action, (5, 1)))
        coarse, culled = view.render(engine), fine.render(engine)
        drawn = fine._drawing.ngeom
        with monkeypatch.context() as patch:
            patch.setattr(camera, "in_sight", lambda *arguments: arguments[-1])
            np.testing.assert_array_equal(culled, fine.render(engine))
        assert drawn < 0.7 * fine._drawing.ngeom
        apart = np.abs(coarse.astype(int) - culled).max(axis=-1)
        assert 0 < (apart > 16).mean() < 0.02
        assert apart[40:].max() == 0  # the arm's part of the picture is at its top
    view.close()
    fine.close()


@needs_opengl
def test_a_camera_on_the_arm_sees_it_in_full() -> None:
    near, far = Camera("panda", "lift", "robot0_eye_in_hand"), Camera("panda", "lift")
    assert near._model.mesh_facenum.sum() > far._model.mesh_facenum.sum()
    near.close()
    far.close()
