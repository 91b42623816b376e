"""Pictures; only where OpenGL is installed, and the message where it is not."""

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from lfr.embodiments import embodiment
from lfr.errors import MissingLibraryError, ParameterError, UnknownNameError
from lfr.robots import ROBOTS
from lfr.sim import camera
from lfr.sim.camera import Camera, camera_available, open_cameras
from lfr.sim.camera_params import STOCK_NAMES, CameraParams
from lfr.sim.simulation import simulation
from lfr.sim.stock import StockSimulation
from lfr.sim.visual import transparent, visual_model
from lfr.tasks import TASKS
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
    assert red(first).sum() > 15, "the red object is not in the picture"
    columns = np.nonzero(red(first))[1]
    position = engine._data.body(next(iter(engine.task.objects.values()))).xpos.copy()
    # the agent's view looks along -x: +y is to the right
    put(engine, np.array([*(position + np.array([0, 0.1, 0.02])), 1, 0, 0, 0]))
    moved = view.render(engine)
    assert np.nonzero(red(moved))[1].mean() > columns.mean() + 5
    view.close()
    view.close()


def places(projection: camera.Projection, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Columns and rows (N, 2) of points (N, 3) of the world, which must be ahead."""
    axes = np.empty(9)
    mujoco.mju_quat2Mat(axes, projection.quaternion)
    rays = (points - projection.position) @ axes.reshape(3, 3) @ projection.intrinsics.T
    assert (rays[:, 2] > 0).all()
    return rays[:, :2] / rays[:, 2:]


def red(picture: NDArray[np.uint8]) -> NDArray[np.bool_]:
    bright = picture.astype(int)
    return (bright[..., 0] > 90) & (bright[..., 0] > 2 * bright[..., 1])


@needs_opengl
@pytest.mark.parametrize(
    ("name", "width", "height"),
    [("agentview", 128, 128), ("agentview", 160, 96), ("wrist", 96, 160)],
)
def test_the_projection_tells_where_a_point_is_in_the_picture(
    name: str, width: int, height: int
) -> None:
    engine, view = simulation("panda", "lift"), Camera("panda", "lift", name, width, height)
    engine.reset(0)
    picture = view.render(engine)
    assert picture.shape == (height, width, 3)
    row, column = (found.mean() for found in np.nonzero(red(picture)))
    cube, _ = engine.body_poses()["cube_main"]
    (found,) = places(view.projection(engine), cube[None])
    assert found == pytest.approx([column + 0.5, row + 0.5], abs=2.0)
    view.close()


@dataclass
class Posed:
    """What a camera asks of a simulation."""

    qpos: NDArray[np.float64]
    size: NDArray[np.float64]

    def position(self) -> NDArray[np.float64]:
        return self.qpos

    def cube_size(self) -> NDArray[np.float64]:
        return self.size


@needs_opengl
@pytest.mark.parametrize("name", ROBOTS)
def test_the_wrist_sees_its_fingers_and_what_is_between_them(name: str) -> None:
    """The pads left and right of it, below the middle, and nothing before them."""
    engine, view = simulation(name, "lift"), Camera(name, "lift", "wrist")
    engine.reset(0)
    assert view.moves
    gripper, model, data = embodiment(name).gripper, view._model, view._data
    fingers = [int(model.joint(joint).qposadr[0]) for joint in gripper.joints]
    cube = model.joint(model.body("cube_main").jntadr[0]).qposadr[0]
    pictures, apart = {}, {}
    for what, at in (("open", gripper.opened), ("closed", gripper.closed)):
        posed: Any = Posed(engine.position(), engine.cube_size())
        posed.qpos[fingers] = at
        seen = view.projection(posed)
        pads = [
            np.mean([data.geom_xpos[model.geom(pad).id] for pad in side], axis=0)
            for side in (gripper.left_pads, gripper.right_pads)
        ]
        posed.qpos[cube : cube + 3] = [0.0, 0.0, 10.0]  # out of the picture
        empty = view.render(posed)
        posed.qpos[cube : cube + 3] = data.site(gripper.grip_site).xpos
        held = view.render(posed)
        found = places(seen, np.array(pads))
        assert (found[:, 1] > 64).all()
        assert (found < 128).all()
        apart[what] = abs(found[0, 0] - found[1, 0])
        between = found[:, 0].min() - 2, found[:, 0].max() + 2
        pictures[what] = empty
        if what == "open":
            assert red(held).sum() > 60, "it does not see what it holds"
            assert between[0] < np.nonzero(red(held))[1].mean() < between[1]
    assert apart["open"] > apart["closed"] + 10
    moved = np.abs(pictures["open"].astype(int) - pictures["closed"]).max(axis=-1) > 40
    assert moved.sum() > 60, "it does not see its fingers"
    assert np.nonzero(moved)[0].mean() > 64
    view.close()


STOCK_POSE = [name for name, robot in ROBOTS.items() if robot.gripper.wrist_camera is None]


@needs_opengl
@pytest.mark.parametrize(
    ("robot", "name"),
    [
        ("panda", "agentview"),
        ("ur5e-joint_position", "frontview"),
        *(
            pytest.param(robot, "wrist", marks=() if robot in ("panda", "ur5e") else [slow])
            for slow in [pytest.mark.slow]
            for robot in STOCK_POSE
        ),
    ],
)
def test_it_is_what_stock_robosuite_draws(robot: str, name: str) -> None:
    """But for shadows, several samples to a pixel and all triangles, which stock has."""
    from robosuite.utils.binding_utils import MjRenderContextOffscreen

    engine, stock = simulation(robot, "lift"), StockSimulation(robot, "lift")
    for one in (engine, stock):
        one.reset(3)
    simulated = stock._env.sim
    theirs = MjRenderContextOffscreen(simulated, device_id=-1)
    theirs.vopt.geomgroup[:2] = 0, 1  # as robosuite's own pictures: no collision geoms
    drawn = simulated.render(width=160, height=96, camera_name=STOCK_NAMES[name])[::-1]
    view = Camera(robot, "lift", name, 160, 96)
    ours = view.render(engine)
    assert (np.abs(ours.astype(int) - drawn).max(axis=-1) > 40).mean() < 0.03
    assert np.corrcoef(ours.ravel(), drawn.ravel())[0, 1] > 0.97
    view.close()


def test_a_mount_looks_along_the_hand_and_towards_its_axis() -> None:
    mount = ROBOTS["sawyer"].gripper.wrist_camera
    assert mount
    axes, angle = np.zeros(9), np.radians(mount.tilt)
    mujoco.mju_quat2Mat(axes, np.array(mount.quaternion))
    right, up, back = axes.reshape(3, 3).T
    np.testing.assert_allclose(right, [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(-back, [-np.sin(angle), 0, np.cos(angle)], atol=1e-12)
    assert up[0] > 0  # the picture's upper edge is the one away from the hand's axis
    model = visual_model("sawyer", "lift")
    there = model.camera(STOCK_NAMES["wrist"])
    np.testing.assert_allclose(there.pos, mount.position)
    np.testing.assert_allclose(there.quat, mount.quaternion)


@needs_opengl
def test_the_wrists_pose_follows_the_hand() -> None:
    engine = simulation("ur5e", "lift")
    engine.reset(2)
    hand, fixed = Camera("ur5e", "lift", "wrist"), Camera("ur5e", "lift", "sideview")
    assert (hand.moves, fixed.moves) == (True, False)
    in_hand, seen = [], []
    for _ in range(3):
        projection = hand.projection(engine)
        position, quaternion = engine.body_poses()["robot0_right_hand"]
        axes = np.empty(9)
        mujoco.mju_quat2Mat(axes, quaternion)
        in_hand.append((projection.position - position) @ axes.reshape(3, 3))
        seen.append([projection.position, fixed.projection(engine).position])
        engine.step(np.tile([0.5, -1.0, 0.7, 0.5, 0.2, 0.3, 0.0], (15, 1)))
    # 2 ms apart: MuJoCo's own positions of bodies after a step lag it by a substep
    np.testing.assert_allclose(in_hand, np.broadcast_to([0.05, 0.0, 0.0], (3, 3)), atol=2e-3)
    moved = np.abs(np.diff(seen, axis=0)).max(axis=(0, 2))
    assert moved[0] > 0.05
    assert moved[1] == 0
    hand.close()
    fixed.close()


@needs_opengl
def test_cameras_that_share_a_context_draw_as_each_alone() -> None:
    engine = simulation("sawyer", "stack")
    wanted = [CameraParams("agentview"), CameraParams("wrist", 96, 64), CameraParams("birdview")]
    engine.reset(0)
    alone = []
    for one in wanted:
        view = Camera("sawyer", "stack", one.name, one.width, one.height)
        alone.append(view.render(engine))
        view.close()
    together = open_cameras("sawyer", "stack", wanted)
    assert [view.name for view in together] == ["agentview", "wrist", "birdview"]
    assert len({id(view._gl) for view in together}) == 1
    for _ in range(2):
        for view, expected in zip(together, alone, strict=True):
            np.testing.assert_array_equal(view.render(engine), expected)
    together[0].close()  # the others go on
    np.testing.assert_array_equal(together[1].render(engine), alone[1])
    for view in together:
        view.close()
    assert open_cameras("sawyer", "stack", []) == ()


@pytest.mark.parametrize("task", TASKS)
def test_the_names_are_those_of_every_scene(task: str) -> None:
    model = visual_model("panda", task)
    missing = {"sideview"} if task == "pick_place" else set()
    names = {model.camera(i).name for i in range(model.ncam)}
    assert names == set(STOCK_NAMES.values()) - missing
    for name in missing:
        with pytest.raises(UnknownNameError, match=rf"camera of {task} '{name}'.*frontview"):
            Camera("panda", task, name)


@pytest.mark.parametrize(
    ("sizes", "found"),
    [((33, 32), "width.*33"), ((32, 0), "height.*0"), ((-2, 2), "width"), ((32, 4098), "4096")],
)
def test_a_size_that_there_is_not_is_refused(sizes: tuple[int, int], found: str) -> None:
    with pytest.raises(ParameterError, match=found):
        CameraParams("wrist", *sizes)


@needs_opengl
def test_two_cameras_of_a_name_are_refused() -> None:
    with pytest.raises(ParameterError, match="wrist more than once"):
        open_cameras("panda", "lift", [CameraParams("wrist"), CameraParams("wrist", 64, 64)])


@pytest.mark.parametrize("name", ["agent", "robot0_eye_in_hand", ""])
def test_an_unknown_camera_lists_the_cameras(name: str) -> None:
    with pytest.raises(UnknownNameError, match=r"agentview.*wrist"):
        Camera("panda", "lift", name)


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
@pytest.mark.parametrize(
    ("task", "name"), [*((task, "agentview") for task in TASKS), ("pick_place", "birdview")]
)
def test_what_cannot_move_is_drawn_once_and_looks_the_same(
    task: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against the whole scene drawn at once, also where the can's target shines through the arm."""
    engine = simulation("panda", task)
    view = Camera("panda", task, name)
    with monkeypatch.context() as patch:
        patch.setattr(camera, "still", lambda model: np.zeros(model.ngeom, dtype=bool))
        at_once = Camera("panda", task, name)
        at_once.render(engine)
    glass = view._visual & transparent(view._model)
    assert glass.any() == (task == "pick_place")
    assert np.count_nonzero(view._each_time) < 0.8 * np.count_nonzero(at_once._each_time)
    through = 0
    for seed in (0, 1):
        engine.reset(seed)
        for _ in range(7):
            engine.step(np.tile([0.25, 1.0, -0.6, 0.0, 0.0, 0.2, 1.0], (5, 1)))
            np.testing.assert_array_equal(view.render(engine), at_once.render(engine))
            moving = view._draw(view._each_time)[1] < 1
            through += np.count_nonzero(moving & (view._draw(glass)[0].sum(axis=-1) > 0))
    assert (through > 20) == glass.any()
    view.close()
    at_once.close()


@needs_opengl
def test_a_camera_on_the_arm_sees_it_in_full() -> None:
    near, far = Camera("panda", "lift", "wrist"), Camera("panda", "lift")
    assert near._model.mesh_facenum.sum() > far._model.mesh_facenum.sum()
    near.close()
    far.close()
