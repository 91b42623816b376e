"""An arm in its task as static rerun entities, one path per body, kept on disk once built.

robosuite needs some five seconds to build a model; the entities made of it are a file of some
megabytes that loads in milliseconds. So the first look at an arm in a task writes that file to the
user's cache, and every later one reads it.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lfr.artifacts import code_fingerprint, fingerprint, write_whole
from lfr.view.geometry import Body, Mesh, Solid, visible_bodies

if TYPE_CHECKING:
    import mujoco
    import rerun as rr
    from rerun.experimental import Chunk

WORLD = "/world"
ANY_TASK = "lift"  # its scene gives the geometry of an arm whose own task is not known
SCENE, MODEL = "scene.rrd", "model.mjb"
APPLICATION = "lfr"


def body_path(body: str, world: str = WORLD) -> str:
    """The entity of a body; its transform is the body's pose in the world frame."""
    return f"{world}/{body}"


def log_scene(
    recording: rr.RecordingStream,
    robot: str,
    task: str,
    world: str = WORLD,
    *,
    placed: Collection[str] | None = None,
) -> tuple[str, ...]:
    """Log everything that can be seen of `robot` in `task`, without motion.

    Bodies that move have no transform here: `lfr.view.episode` gives them theirs over time.

    Args:
        recording: where to log to.
        robot, task: names, as in `lfr.embodiments` and `lfr.tasks`.
        world: path under which the bodies stand; another one sets a second scene beside the first.
        placed: bodies whose poses are known; what moves and is none of them is left out.

    Returns:
        The names of the bodies that move.

    Raises:
        UnknownNameError: no robot or task has that name.
    """
    chunks = _chunks(robot, task)
    moving = _moving(chunks)
    hidden = () if placed is None else set(moving) - set(placed)
    _send(recording, [chunk for chunk in chunks if _body(chunk) not in hidden], world)
    return tuple(body for body in moving if body not in hidden)


def log_arm(recording: rr.RecordingStream, robot: str, placed: Collection[str]) -> tuple[str, ...]:
    """Log what can be seen of the bodies `placed` of an arm and nothing around it, all poses aside.

    Returns:
        The names of the bodies that can be seen; even those that never move have no transform yet.

    Raises:
        UnknownNameError: no robot has that name.
    """
    chunks = _chunks(robot, ANY_TASK)
    fixed = {body_path(body) for body in placed}
    shown = [c for c in chunks if _body(c) in placed and c.entity_path not in fixed]
    _send(recording, shown, WORLD)
    return tuple(dict.fromkeys(body for chunk in shown if (body := _body(chunk))))


def moving_bodies(robot: str, task: str) -> tuple[str, ...]:
    """The names of the bodies that can be seen and move.

    Raises:
        UnknownNameError: no robot or task has that name.
    """
    return _moving(_chunks(robot, task))


def _chunks(robot: str, task: str) -> list[Chunk]:
    from rerun.experimental import RrdReader

    return RrdReader(scene_folder(robot, task) / SCENE).stream().to_chunks()


def _send(recording: rr.RecordingStream, chunks: Sequence[Chunk], world: str) -> None:
    recording.send_chunks(
        chunk.with_entity_path(world + chunk.entity_path.removeprefix(WORLD)) for chunk in chunks
    )


def _moving(chunks: list[Chunk]) -> tuple[str, ...]:
    fixed = {_body(chunk) for chunk in chunks if chunk.entity_path.count("/") == 2}  # have a pose
    bodies = dict.fromkeys(_body(chunk) for chunk in chunks)
    return tuple(body for body in bodies if body and body not in fixed)


def _body(chunk: Chunk) -> str | None:
    """The body that an entity `/world/<body>/...` is of; None of the world itself."""
    return next(iter(chunk.entity_path.removeprefix(WORLD).split("/")[1:]), None)


def kinematic_model(robot: str, task: str) -> mujoco.MjModel:
    """The model without its visual geoms, to compute the poses of bodies with."""
    import mujoco

    return mujoco.MjModel.from_binary_path(str(scene_folder(robot, task) / MODEL))


def scene_folder(robot: str, task: str) -> Path:
    """A scene's folder in the cache, built if it is not there yet: `scene.rrd` and `model.mjb`."""
    import lfr.tasks
    from lfr.embodiments import embodiment

    arm = embodiment(robot).robot.name  # whatever its controller
    made_of = fingerprint(
        arm,
        lfr.tasks.task(task).name,
        code_fingerprint("lfr.view.geometry", "lfr.view.scene", "lfr.sim.scene", "lfr.robots"),
        *(version(package) for package in ("robosuite", "mujoco", "rerun-sdk")),
    )
    folder = _cache() / f"{arm}-{task}-{made_of}"
    if not folder.is_dir():
        with write_whole(folder) as partial:
            partial.mkdir()
            _build(arm, task, partial)
    return folder


def log_bodies(recording: rr.RecordingStream, bodies: Iterable[Body], world: str = WORLD) -> None:
    """Log the geometry of bodies, and the pose of those that never move."""
    import rerun as rr

    recording.log(world, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for body in bodies:
        path = body_path(body.name, world)
        if body.fixed:
            pose = rr.Transform3D(
                translation=body.position,
                quaternion=rr.Quaternion(xyzw=np.roll(body.quaternion, -1)),
            )
            recording.log(path, pose, static=True)
        for number, mesh in enumerate(body.meshes):
            name = "mesh" if number == 0 else f"mesh{number}"
            recording.log(f"{path}/{name}", mesh_archetype(mesh), static=True)
        for kind in dict.fromkeys(solid.kind for solid in body.solids):
            solids = [solid for solid in body.solids if solid.kind == kind]
            recording.log(f"{path}/{kind}", solid_archetype(kind, solids), static=True)


def mesh_archetype(mesh: Mesh) -> rr.Mesh3D:
    """A mesh as rerun draws it, of one colour where it has one: only that may be transparent."""
    import rerun as rr

    plain = bool((mesh.colors == mesh.colors[0]).all())
    return rr.Mesh3D(
        vertex_positions=mesh.positions,
        vertex_normals=mesh.normals,
        triangle_indices=mesh.triangles,
        vertex_colors=None if plain else mesh.colors,
        albedo_factor=mesh.colors[0] if plain else None,
        vertex_texcoords=mesh.texcoords,
        albedo_texture=mesh.texture,
    )


def solid_archetype(
    kind: str, solids: list[Solid]
) -> rr.Boxes3D | rr.Cylinders3D | rr.Capsules3D | rr.Ellipsoids3D:
    """Primitives of one kind as one batch."""
    import rerun as rr

    centers = np.array([solid.center for solid in solids])
    quaternions = np.array([solid.quaternion for solid in solids])
    sizes = np.array([solid.size for solid in solids])
    colors = np.array([solid.color for solid in solids])
    placed = {
        "quaternions": quaternions,
        "colors": colors,
        "fill_mode": rr.components.FillMode.Solid,
    }
    match kind:
        case "box":
            return rr.Boxes3D(half_sizes=sizes, centers=centers, **placed)
        case "cylinder":
            return rr.Cylinders3D(
                radii=sizes[:, 0], lengths=2 * sizes[:, 1], centers=centers, **placed
            )
        case "capsule":  # rerun's begins at its origin, MuJoCo's is centred there
            axes = np.array([_z_axis(quaternion) for quaternion in quaternions])
            starts = centers - axes * sizes[:, 1:2]
            return rr.Capsules3D(
                radii=sizes[:, 0], lengths=2 * sizes[:, 1], translations=starts, **placed
            )
        case _:
            return rr.Ellipsoids3D(half_sizes=sizes, centers=centers, **placed)


def _z_axis(quaternion: np.ndarray) -> np.ndarray:
    x, y, z, w = quaternion
    return np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])


def _build(robot: str, task: str, folder: Path) -> None:
    import mujoco
    import rerun as rr

    import lfr.tasks
    from lfr.embodiments import embodiment
    from lfr.sim.scene import pruned_spec
    from lfr.sim.stock import make_stock_environment, repaired_xml

    arm, chosen = embodiment(robot).robot, lfr.tasks.task(task)
    environment = make_stock_environment(robot, task, hard_reset=True)
    environment.reset()
    xml = repaired_xml(environment, arm)
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    data.qpos[:] = environment.sim.data.qpos
    mujoco.mj_kinematics(model, data)
    # PickPlace also marks, half transparent, where each of its objects belongs.
    marks = {f"Visual{name}" for name in chosen.unused_objects}
    bodies = visible_bodies(model, data, hidden={*chosen.unused_objects, *marks})
    with rr.RecordingStream(APPLICATION, recording_id="scene", send_properties=False) as recording:
        recording.save(folder / SCENE)
        log_bodies(recording, bodies)
        recording.flush()
        recording.disconnect()

    mujoco.mj_saveModel(pruned_spec(xml, arm, chosen).compile(), str(folder / MODEL))


def _cache() -> Path:
    """The user's cache, because a scene depends on versions alone and serves every project."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "lfr" / "scenes"
