"""The scene of a task: robosuite builds the MJCF, MjSpec takes out what physics does not need.

Taken out: visual geoms, sensors, cameras and lights, the objects that robosuite builds and parks
10 m away, and the collision geoms of the arm's proximal links and of its mount. The last changes
physics only when those links touch something; the distal links, hand and fingers keep their geoms.
Bodies that cannot move and that nothing can touch are taken out too, and the others that cannot
move lose their mass: otherwise MuJoCo computes the drag of the air on them in every step.
"""

from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

import lfr.robots
import lfr.tasks
from lfr.errors import LfrError
from lfr.robots import Robot
from lfr.sim.placement import start_arrays
from lfr.sim.start import StartArrays
from lfr.sim.stock import make_stock_environment
from lfr.tasks import Task

OTHER, LEFT_PAD, RIGHT_PAD, FIRST_OBJECT, SECOND_OBJECT = range(5)
"""What a geom is to the grasp and contact checks."""


class SceneArrays(NamedTuple):
    """What the kernel must know of a scene; the same types for every robot and task.

    Ids that a task lacks are 0. Lengths in m, world frame.
    """

    task: int  # Task.identifier
    base_body: int
    controller_site: int
    grip_site: int
    finger_first: int  # qpos address; opening raises it
    finger_second: int
    pad_gap_at_zero: float
    first_object: int  # body
    second_object: int
    handle_site: int
    peg_body: int
    surface_z: float  # of the table top or the bin's bottom
    lift_z: float  # height that completes the lifting reward
    bin_size: NDArray[np.float64]  # (2,) of one of the four target bins, x and y
    bin_target: NDArray[np.float64]  # (3,) centre of the target bin
    geom_kind: NDArray[np.int64]  # (ngeom,)
    ctrl_range: NDArray[np.float64]  # (nu, 2)
    close_signs: NDArray[np.float64]  # (2,)
    inertia_index: NDArray[np.int64]  # (7, 7) places of the arm's block in MjData.qM


@dataclass(frozen=True)
class Scene:
    """A pruned model, what the kernel must know of it, and how its episodes start."""

    robot: Robot
    task: Task
    model: mujoco.MjModel
    arrays: SceneArrays
    start: StartArrays


def build_scene(robot: str, task: str) -> Scene:
    """Build the scene of `task` with `robot`.

    Raises:
        UnknownNameError: unknown robot or task.
        LfrError: robosuite's model is not laid out as the kernel needs it.
    """
    arm, chosen = lfr.robots.robot(robot), lfr.tasks.task(task)
    environment = make_stock_environment(robot, task, hard_reset=False)
    xml = environment.edit_model_xml(environment.model.get_xml())
    model = pruned_spec(xml, arm, chosen).compile()
    data = mujoco.MjData(model)
    _unburden(model, data)
    mujoco.mj_forward(model, data)
    _check_layout(model, arm)
    return Scene(
        robot=arm,
        task=chosen,
        model=model,
        arrays=_arrays(environment, model, data, arm, chosen),
        start=start_arrays(environment, model),
    )


def pruned_spec(xml: str, robot: Robot, task: Task) -> mujoco.MjSpec:
    """robosuite's MJCF without what the physics of this task does not need."""
    spec = mujoco.MjSpec.from_string(xml)
    for sensor in list(spec.sensors):
        spec.delete(sensor)
    for name in task.unused_objects:
        spec.delete(spec.body(name))
    for element in [*spec.cameras, *spec.lights]:
        spec.delete(element)
    for first, second in robot.excluded_contacts:
        spec.add_exclude(bodyname1=first, bodyname2=second)
    kept = ("gripper0_", *robot.distal_bodies)
    for body in spec.bodies:
        if body.name.startswith(("robot0_", "fixed_mount0_")) and not body.name.startswith(kept):
            for geom in body.geoms:
                geom.contype = geom.conaffinity = 0
    for body in list(spec.worldbody.bodies):
        _delete_scenery(spec, body, robot)
    spec.compiler.discardvisual = True
    # Otherwise MuJoCo answers a divergence with a reset of its own, and the kernel never sees it.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET.value
    # With so few bodies, finding what can be solved apart costs more than it saves.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND.value
    return spec


def _delete_scenery(spec: mujoco.MjSpec, body: mujoco.MjsBody, robot: Robot) -> bool:
    """Delete a body, and those on it, that no joint moves and nothing touches; whether it went."""
    stays = bool(body.joints) or any(geom.contype or geom.conaffinity for geom in body.geoms)
    stays |= body.name == robot.base_body
    stays |= any(site.name == robot.controller_site for site in body.sites)
    if body.joints:  # all that hangs on it moves with it
        return False
    stays |= not all([_delete_scenery(spec, child, robot) for child in list(body.bodies)])
    if not stays:
        spec.delete(body)
    return not stays


def _unburden(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Take the mass of bodies that are fixed to the world: it does nothing but cost time."""
    fixed = model.body_weldid == 0
    model.body_mass[fixed] = 0.0
    model.body_inertia[fixed] = 0.0
    mujoco.mj_setConst(model, data)


def _check_layout(model: mujoco.MjModel, robot: Robot) -> None:
    names = tuple(model.joint(j).name for j in range(len(robot.joints)))
    hinges = bool((model.jnt_type[: len(names)] == mujoco.mjtJoint.mjJNT_HINGE).all())
    if names != robot.joints or not hinges or model.nu != len(names) + 2:
        raise LfrError(
            f"{robot.name}: found joints {', '.join(names)} and {model.nu} actuators, expected the "
            f"hinges {', '.join(robot.joints)} first, then two finger actuators"
        )


def _arrays(
    environment: object,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    robot: Robot,
    task: Task,
) -> SceneArrays:
    bodies = [model.body(name).id for name in task.objects.values()]
    bins, pegs = task.name == "pick_place", task.name == "nut_assembly"
    bin_position = np.array(getattr(environment, "bin2_pos", np.zeros(3)), dtype=np.float64)
    table = np.array(getattr(environment, "table_offset", np.zeros(3)), dtype=np.float64)
    bin_size = np.array(getattr(environment, "bin_size", np.zeros(3))[:2], dtype=np.float64) / 2
    target = bin_position + np.array([*bin_size / 2, 0.0])
    first, second = (model.joint(name).qposadr[0] for name in robot.finger_joints)
    return SceneArrays(
        task=task.identifier,
        base_body=model.body(robot.base_body).id,
        controller_site=model.site(robot.controller_site).id,
        grip_site=model.site(robot.grip_site).id,
        finger_first=int(first),
        finger_second=int(second),
        pad_gap_at_zero=robot.pad_gap_at_zero,
        first_object=bodies[0],
        second_object=bodies[1] if len(bodies) > 1 else 0,
        handle_site=model.site("SquareNut_handle_site").id if pegs else 0,
        peg_body=model.body("peg1").id if pegs else 0,
        surface_z=float(bin_position[2] if bins else table[2]),
        lift_z=float(bin_position[2] + 0.25 if bins else data.body("table").xpos[2] + 0.2),
        bin_size=bin_size,
        bin_target=target,
        geom_kind=_geom_kinds(model, robot, bodies),
        ctrl_range=np.ascontiguousarray(model.actuator_ctrlrange),
        close_signs=np.array(robot.close_signs),
        inertia_index=_inertia_index(model, len(robot.joints)),
    )


def _geom_kinds(model: mujoco.MjModel, robot: Robot, bodies: list[int]) -> NDArray[np.int64]:
    kinds = np.full(model.ngeom, OTHER, dtype=np.int64)
    for body, kind in zip(bodies, (FIRST_OBJECT, SECOND_OBJECT), strict=False):
        kinds[model.geom_bodyid == body] = kind
    for names, kind in ((robot.left_pads, LEFT_PAD), (robot.right_pads, RIGHT_PAD)):
        for name in names:
            kinds[model.geom(name).id] = kind
    return kinds


def _inertia_index(model: mujoco.MjModel, size: int) -> NDArray[np.int64]:
    """Place of M[i, j], i >= j, in the sparse inertia: a dof's row walks up to its ancestors."""
    index = np.zeros((size, size), dtype=np.int64)
    for i in range(size):
        ancestor = i
        for offset in range(i + 1):
            index[i, ancestor] = index[ancestor, i] = model.dof_Madr[i] + offset
            ancestor = model.dof_parentid[ancestor]
    return index
