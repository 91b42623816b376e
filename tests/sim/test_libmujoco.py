"""What is read from MuJoCo's structs, and what happens with a library that was not checked."""

import mujoco
import numpy as np
import pytest

from lfr.errors import LfrError
from lfr.sim import compilation, libmujoco
from lfr.sim.simulation import simulation


def test_contacts_are_those_of_the_bindings() -> None:
    engine = simulation("panda", "stack")
    counts = set()
    for steps in (0, 1, 15):  # the cubes are let go above the table, then the hand comes down
        engine.reset(0)
        mujoco.mj_forward(engine._model, engine._data)
        engine.step(np.tile([0.2, 0, -1, 0, 0, 0, 0], (steps, 1)))
        count = engine._data.ncon
        assert engine._physics.contact_count[0] == count
        np.testing.assert_array_equal(
            engine._physics.contact_geoms[:count], engine._data.contact.geom
        )
        counts.add(count)
    assert 0 in counts
    assert max(counts) > 4


def test_sparse_inertia_is_read_in_the_right_places() -> None:
    engine = simulation("sawyer", "lift")
    full = np.zeros((engine._model.nv, engine._model.nv))
    mujoco.mj_fullM(engine._model, full, engine._data.qM)
    ours = engine._data.qM[engine._scene.arrays.inertia_index]
    np.testing.assert_array_equal(ours, full[:7, :7])


def test_an_unchecked_mujoco_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mujoco, "__version__", "3.12.0")
    with pytest.raises(LfrError, match=r"MuJoCo 3\.12\.0 found.*3\.9\.x"):
        libmujoco.load()


def test_an_unknown_contact_layout_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    free = mujoco.MjModel.from_xml_string("<mujoco><worldbody/></mujoco>")
    monkeypatch.setattr(libmujoco, "_spheres", lambda count: (free, mujoco.MjData(free)))
    with pytest.raises(LfrError, match="lays out its contacts"):
        libmujoco._contact_layout.__wrapped__()


def test_without_a_writable_cache_compilation_says_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(compilation, "_writable", lambda folder: False)
    monkeypatch.setattr(compilation, "cache_folder", compilation.cache_folder.__wrapped__)
    compilation._announce.cache_clear()
    with compilation.compiling_once():
        pass
    assert "no cache folder can be written" in capsys.readouterr().err
