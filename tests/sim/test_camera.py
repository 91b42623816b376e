"""Pictures; only where OpenGL is installed, and the message where it is not."""

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
def test_an_unknown_camera_lists_the_cameras() -> None:
    with pytest.raises(UnknownNameError, match="agentview"):
        Camera("panda", "lift", name="agent")


def test_missing_opengl_names_the_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "nonesuch")
    with pytest.raises(MissingLibraryError, match="libegl1 and libegl-mesa0"):
        camera._opengl_context(8, 8)
