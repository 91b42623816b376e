"""What a dimension is, by its name."""

import math

import pytest

from lfr.embodiments import embodiment, embodiments, is_known, known_action
from lfr.errors import UnknownNameError
from lfr.robots import ROBOTS
from lfr.spaces import ROBOT_STATE, Space, displacement, position, quantity, space
from lfr.tasks import TASKS


@pytest.mark.parametrize(
    ("task", "size"), [("lift", 11), ("stack", 17), ("pick_place", 12), ("nut_assembly", 19)]
)
def test_sizes_and_places(task: str, size: int) -> None:
    layout, environment = TASKS[task].observation, TASKS[task].environment
    assert ROBOT_STATE.size == 11
    assert environment.size == size
    assert layout.names == ROBOT_STATE.names + environment.names
    assert len(set(layout.names)) == layout.size == 11 + size
    assert layout.names[layout.index("gripper_command")] == "gripper_command"
    assert layout.slice(f"eef_to_{TASKS[task].manipulated}") == slice(17, 20)
    assert layout.slice("gripper_aperture") == slice(9, 10)


def test_unknown_names_list_the_known_ones() -> None:
    layout = TASKS["lift"].observation
    with pytest.raises(UnknownNameError, match=r"cube_pos\.x"):
        layout.index("cube_pos")
    with pytest.raises(UnknownNameError, match="cube_yaw"):
        layout.slice("nut_yaw")
    with pytest.raises(UnknownNameError, match=r"gripper_aperture.*<thing>_pos.*<start>_to_<end>"):
        quantity("wrist_torque")


@pytest.mark.parametrize("task", TASKS)
def test_a_name_says_of_a_quantity_what_its_task_says(task: str) -> None:
    """All but the rotational symmetry, which the task alone knows."""
    layout = TASKS[task].observation
    for told, read in zip(layout.quantities, space(layout.names).quantities, strict=True):
        assert (told.names, told.unit, told.frame) == (read.names, read.unit, read.frame)
        assert (told.moves, told.low, told.high) == (read.moves, read.low, read.high)
        assert (told.std_floor, told.to_zero) == (read.std_floor, read.to_zero)


@pytest.mark.parametrize("name", [body.name for body in embodiments()])
def test_an_action_is_read_off_its_names(name: str) -> None:
    action = embodiment(name).action
    read = space(action.names)
    assert [q.moves for q in action.quantities] == [q.moves for q in read.quantities]
    assert [q.unit for q in action.quantities] == [q.unit for q in read.quantities]
    assert action.names[-1] == "gripper"
    found = known_action(action.names, name)
    assert found == action


def test_numbers_of_which_nothing_is_said() -> None:
    one, joint = space(["number.torque", "joint.elbow"]).quantities
    assert (one.moves, one.unit, one.high) == ("unknown", "", math.inf)
    assert (joint.unit, joint.names) == ("rad", ("joint.elbow",))


def test_no_dimension_twice() -> None:
    with pytest.raises(ValueError, match=r"cube_pos\.x"):
        Space((position("cube"), position("cube")))


def test_a_displacement_leads_from_its_first_thing_to_its_second() -> None:
    assert displacement("eef", "cube").about == "vector from the grip site to cube"


def test_an_embodiment_is_known_by_one_name() -> None:
    assert {body.robot.name for body in embodiments()} == set(ROBOTS)
    for body in embodiments():
        assert embodiment(body.name) == body
    assert embodiment("panda").controller.name == "osc_pose"
    assert is_known("jaco-joint_position")
    for wrong in (
        "pandas",
        "panda-",
        "panda-osc",
        "panda-osc_pose",
        "panda-joint_position-x",
        "panda_joint_position",
    ):
        assert not is_known(wrong)
        with pytest.raises(UnknownNameError):
            embodiment(wrong)


def test_joint_motions_are_an_arms_own_also_where_joints_are_called_alike() -> None:
    panda, xarm = (embodiment(f"{arm}-joint_position") for arm in ("panda", "xarm7"))
    assert panda.action.names == xarm.action.names
    assert not panda.shares_actions(xarm)
    assert embodiment("panda").shares_actions(embodiment("xarm7"))
    assert not embodiment("panda").shares_actions(panda)
