"""Kept scenes: the same as newly built ones, and replaced when they are damaged."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from lfr.sim import compilation, scene_cache
from lfr.sim.scene import Scene, build_scene


def bytes_of(model: mujoco.MjModel) -> bytes:
    buffer = np.empty(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


def assert_equal(found: Scene, built: Scene) -> None:
    assert bytes_of(found.model) == bytes_of(built.model)
    for part, its in ((found.arrays, built.arrays), (found.start, built.start)):
        for name, value in its._asdict().items():
            kept = getattr(part, name)
            assert type(kept) is type(value), name
            np.testing.assert_array_equal(kept, value)
            assert np.asarray(kept).dtype == np.asarray(value).dtype
    assert (found.embodiment, found.task) == (built.embodiment, built.task)


@pytest.mark.parametrize(
    ("robot", "task"), [("panda", "lift"), ("iiwa-joint_position", "stack"), ("ur5e", "pick_place")]
)
def test_a_kept_scene_is_the_built_one(
    robot: str, task: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scene_cache, "scene_folder", lambda: tmp_path)
    built = scene_cache.load_scene(robot, task)
    monkeypatch.setattr(scene_cache, "build_scene", None)  # from here on it must be read
    assert_equal(scene_cache.load_scene(robot, task), built)


def test_a_damaged_file_is_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(scene_cache, "scene_folder", lambda: tmp_path)
    built = scene_cache.load_scene("panda", "lift")
    file = tmp_path / "panda-lift.npz"
    file.write_bytes(file.read_bytes()[:5000])
    assert_equal(scene_cache.load_scene("panda", "lift"), built)
    assert "cannot be read" in caplog.text
    caplog.clear()
    scene_cache.load_scene("panda", "lift")
    assert not caplog.text
    assert [path.name for path in tmp_path.iterdir()] == ["panda-lift.npz"]


def test_without_a_place_to_keep_it_the_scene_is_built(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compilation, "_writable", lambda folder: False)
    assert scene_cache.scene_folder.__wrapped__() is None
    monkeypatch.setattr(scene_cache, "scene_folder", lambda: None)
    assert_equal(scene_cache.load_scene("panda", "lift"), build_scene("panda", "lift"))


def test_bodies_without_a_part_in_the_physics_are_gone_and_the_rest_is_as_heavy() -> None:
    from lfr.sim.stock import make_stock_environment

    model = scene_cache.load_scene("panda", "pick_place").model
    full = make_stock_environment("panda", "pick_place", hard_reset=False).sim.model._model
    moving = 0
    for body in (model.body(i) for i in range(1, model.nbody)):
        if model.body_weldid[body.id] != 0:
            moving += 1
            assert body.mass[0] == full.body(body.name).mass[0]
            np.testing.assert_array_equal(body.inertia, full.body(body.name).inertia)
        else:
            assert body.mass[0] == 0
    assert moving > 12
    names = {model.body(i).name for i in range(model.nbody)}
    assert {"bin1", "bin2", "robot0_base"} <= names
    assert not any("mount" in name or name.startswith("Visual") for name in names)
