"""The scene of a task: robosuite builds the MJCF, MjSpec takes out what physics does not need.

Taken out: visual geoms, sensors, cameras and lights, the objects that robosuite builds and parks
10 m away, and the collision geoms of the arm's proximal links and of its mount. The last changes
physics only when those links touch something; the distal links, hand and fingers keep their geoms.
Bodies that cannot move and that nothing can touch are taken out too, and the others that cannot
move lose their mass: otherwise MuJoCo computes the drag of the air on them in every step.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

import lfr.tasks
from lfr.compiled import contacts, frames
from lfr.compiled.arrays import SceneArrays
from lfr.controllers import CONTROLLERS
from lfr.embodiments import Embodiment, embodiment
from lfr.errors import LfrError
from lfr.robots import Robot
from lfr.sim.pads import pad_depth, pad_geoms
from lfr.sim.placement import start_arrays
from lfr.sim.start import StartArrays
from lfr.sim.stock import make_stock_environment, repaired_xml
from lfr.tasks import TASKS, Task
from lfr.tasks.task import EEF, Place

PLACE_KINDS = {"body": frames.BODY, "site": frames.SITE, "point": frames.POINT}


@dataclass(frozen=True)
class Scene:
    """A pruned model, what the kernel must know of it, and how its episodes start."""

    embodiment: Embodiment
    task: Task
    model: mujoco.MjModel
    arrays: SceneArrays
    start: StartArrays


def build_scene(name: str, task: str) -> Scene:
    """Build the scene of `task` with the embodiment called `name`.

    Raises:
        UnknownNameError: unknown embodiment or task.
        LfrError: robosuite's model is not laid out as the kernel needs it.
    """
    body, chosen = embodiment(name), lfr.tasks.task(task)
    environment = make_stock_environment(name, task, hard_reset=False)
    model = pruned_spec(repaired_xml(environment, body.robot), body.robot, chosen).compile()
    data = mujoco.MjData(model)
    _unburden(model, data)
    mujoco.mj_forward(model, data)
    _check_layout(model, body.robot)
    return Scene(
        embodiment=body,
        task=chosen,
        model=model,
        arrays=_arrays(environment, model, body, chosen),
        start=start_arrays(environment, model, chosen),
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
    missing = set(robot.distal_bodies) - {body.name for body in spec.bodies}
    if missing:
        raise LfrError(f"{robot.name}: the model has no bodies {', '.join(sorted(missing))}")
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
    expected = (*robot.joints, *robot.gripper.joints)
    found = tuple(model.joint(j).name for j in range(min(len(expected), model.njnt)))
    hinges = bool((model.jnt_type[: len(robot.joints)] == mujoco.mjtJoint.mjJNT_HINGE).all())
    actuators = len(robot.joints) + len(robot.gripper.close_signs)
    if found != expected or not hinges or model.nu != actuators:
        raise LfrError(
            f"{robot.name}: found joints {', '.join(found)} and {model.nu} actuators; expected "
            f"first the hinges {', '.join(robot.joints)}, then {', '.join(robot.gripper.joints)}, "
            f"and {actuators} actuators"
        )


def _arrays(environment: Any, model: mujoco.MjModel, body: Embodiment, task: Task) -> SceneArrays:
    robot, gripper = body.robot, body.gripper
    bodies = [model.body(name).id for name in task.objects.values()]
    places = (Place("site", gripper.grip_site), *task.places)
    numbers = {EEF: 0, **{place: i for i, place in enumerate(task.places, 1)}}
    points = task.points(environment)
    return SceneArrays(
        task=tuple(TASKS).index(task.name),
        controller=tuple(CONTROLLERS).index(body.controller.name),
        base_body=model.body(robot.base_body).id,
        controller_site=model.site(robot.controller_site).id,
        grip_site=model.site(gripper.grip_site).id,
        objects=np.array([*bodies, -1][:2]),
        geom_kind=_geom_kinds(model, robot, bodies),
        pad_geoms=pad_geoms(model, gripper),
        pad_depth=pad_depth(model, gripper),
        ctrl_range=np.ascontiguousarray(model.actuator_ctrlrange),
        close_signs=np.array(gripper.close_signs),
        finger_speed=gripper.speed,
        inertia_index=_inertia_index(model, len(robot.joints)),
        action_scale=np.array(body.action_scale),
        place_kind=np.array([PLACE_KINDS[place.kind] for place in places]),
        place_id=np.array([_place_id(model, place) for place in places]),
        place_point=np.array([_place_point(points, task, place) for place in places]),
        term_kind=np.array([term.kind for term in task.terms]),
        term_to=np.array([numbers[term.to] for term in task.terms]),
        term_from=np.array([numbers[term.origin] for term in task.terms]),
        term_fold=np.array([float(term.quantity.fold) for term in task.terms]),
        constants=np.array(task.constants(environment), dtype=np.float64),
    )


def _place_id(model: mujoco.MjModel, place: Place) -> int:
    if place.kind == "point":
        return -1
    return (model.body if place.kind == "body" else model.site)(place.name).id


def _place_point(points: Mapping[str, Any], task: Task, place: Place) -> Any:
    if place.kind != "point":
        return np.zeros(3)
    if place.name not in points:
        raise LfrError(
            f"{task.name}: no point {place.name!r}; found: {', '.join(points) or 'none'}"
        )
    return points[place.name]


def _geom_kinds(model: mujoco.MjModel, robot: Robot, bodies: list[int]) -> NDArray[np.int64]:
    kinds = np.full(model.ngeom, contacts.OTHER, dtype=np.int64)
    objects = (contacts.FIRST_OBJECT, contacts.SECOND_OBJECT)
    for body, kind in zip(bodies, objects, strict=False):
        kinds[model.geom_bodyid == body] = kind
    pads = {
        contacts.LEFT_PAD: robot.gripper.left_pads,
        contacts.RIGHT_PAD: robot.gripper.right_pads,
    }
    for kind, names in pads.items():
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
