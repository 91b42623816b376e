"""What a task is: its objects, its horizon, its words, and the names of what is observed in it."""

from dataclasses import dataclass, field

from lfr.errors import UnknownNameError

XYZ = ("x", "y", "z")
YAW = ("cos", "sin")


@dataclass(frozen=True)
class Task:
    """One robosuite task for one arm.

    Attributes:
        name: this project's name of the task.
        stock_name: robosuite's name of it.
        identifier: number by which the compiled kernel tells the tasks apart.
        horizon: control steps (20 Hz) after which an episode ends.
        instruction: the task in words, for datasets.
        objects: observed object -> its root body in robosuite's MJCF, the manipulated one first.
        unused_objects: root bodies that robosuite builds and parks away from the scene.
        environment: groups of `observation.environment_state` in order, each with its components.
        stock_options: further keyword arguments of robosuite's environment.
    """

    name: str
    stock_name: str
    identifier: int
    horizon: int
    instruction: str
    objects: dict[str, str]
    environment: tuple[tuple[str, tuple[str, ...]], ...]
    unused_objects: tuple[str, ...] = ()
    stock_options: dict[str, object] = field(default_factory=dict)

    @property
    def environment_names(self) -> tuple[str, ...]:
        """Name of every dimension of `observation.environment_state`, e.g. `cube_pos.x`."""
        return tuple(f"{group}.{part}" for group, parts in self.environment for part in parts)


def _pose(name: str, *, yaw: bool = True) -> tuple[tuple[str, tuple[str, ...]], ...]:
    groups = ((f"{name}_pos", XYZ), (f"{name}_up", XYZ), (f"{name}_to_eef", XYZ))
    return groups + (((f"{name}_yaw", YAW),) if yaw else ())


TASKS: dict[str, Task] = {
    "lift": Task(
        name="lift",
        stock_name="Lift",
        identifier=0,
        horizon=150,
        instruction="lift the cube",
        objects={"cube": "cube_main"},
        environment=_pose("cube"),
    ),
    "stack": Task(
        name="stack",
        stock_name="Stack",
        identifier=1,
        horizon=250,
        instruction="stack the red cube on the green cube",
        objects={"cubeA": "cubeA_main", "cubeB": "cubeB_main"},
        environment=(*_pose("cubeA"), ("cubeB_pos", XYZ), ("cubeA_to_cubeB", XYZ)),
    ),
    "pick_place": Task(
        name="pick_place",
        stock_name="PickPlaceCan",
        identifier=2,
        horizon=300,
        instruction="pick the can and place it into its bin",
        objects={"can": "Can_main"},
        environment=(*_pose("can", yaw=False), ("can_to_bin", XYZ)),
        unused_objects=("Milk_main", "Bread_main", "Cereal_main"),
    ),
    "nut_assembly": Task(
        name="nut_assembly",
        stock_name="NutAssemblySquare",
        identifier=3,
        horizon=300,
        instruction="put the square nut onto its peg",
        objects={"nut": "SquareNut_main"},
        environment=(
            *_pose("nut"),
            ("handle_to_eef", XYZ),
            ("nut_to_peg", XYZ),
            ("nut_peg_yaw", YAW),
        ),
        unused_objects=("RoundNut_main",),
    ),
}


def task(name: str) -> Task:
    """The task called `name`.

    Raises:
        UnknownNameError: there is none; the message lists those there are.
    """
    if name not in TASKS:
        raise UnknownNameError("task", name, tuple(TASKS))
    return TASKS[name]
