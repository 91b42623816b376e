"""The grippers that robosuite's arms carry."""

from __future__ import annotations

from itertools import chain

from lfr.robots.repair import Coupling, Repair
from lfr.robots.robot import Gripper, Mount

_G = "gripper0_right_"


def _named(*names: str) -> tuple[str, ...]:
    return tuple(_G + name for name in names)


PANDA_GRIPPER = Gripper(
    name="panda_gripper",
    stock_name="PandaGripper",
    joints=_named("finger_joint1", "finger_joint2"),
    opened=(0.04, -0.04),
    closed=(0.0, 0.0),
    left_pads=_named("finger1_pad_collision"),
    right_pads=_named("finger2_pad_collision"),
    close_signs=(-1.0, 1.0),
)

RETHINK_GRIPPER = Gripper(
    name="rethink_gripper",
    stock_name="RethinkGripper",
    joints=_named("l_finger_joint", "r_finger_joint"),
    opened=(0.020833, -0.020833),
    closed=(-0.0115, 0.0115),
    left_pads=_named("l_fingerpad_g0"),
    right_pads=_named("r_fingerpad_g0"),
    close_signs=(1.0, -1.0),
    wrist_camera=Mount((0.1, 0.0, 0.0), 15.0),  # robosuite's sees its housing alone
)

_ROBOTIQ_JOINTS = _named(
    *("finger_joint", "left_inner_finger_joint", "left_inner_knuckle_joint"),
    *("right_outer_knuckle_joint", "right_inner_finger_joint", "right_inner_knuckle_joint"),
)


def _grip_site(deeper: float) -> Repair:
    """The grip site moved along the approach, so that the pads hold what it is brought to (m)."""
    return Repair(
        why=(f"Its grip site is {1000 * deeper:g} mm deeper, between the pads.",),
        shifts=(("site", f"{_G}grip_site", (0.0, 0.0, deeper)),),
    )


def _parallel_jaw(
    inner_finger: tuple[int, int], inner_knuckle: tuple[int, int], force: float
) -> Repair:
    """Robotiq's linkage: the inner joints follow the outer one, so that the pads stay parallel.

    robosuite's links are held together by a spring alone, without armature or damping, and run
    into each other: pads tilt by up to 40 degrees and never close under load.

    Args:
        inner_finger, inner_knuckle: ratios to the outer joint of the left and the right finger.
        force: bound on either actuator's torque (N m), which robosuite lets squeeze a cube away.
    """
    drivers = ("finger_joint", "right_outer_knuckle_joint")
    sides = tuple(zip(("left", "right"), drivers, inner_finger, inner_knuckle, strict=True))
    couplings = chain.from_iterable(
        (
            Coupling(f"{_G}{side}_inner_finger_joint", _G + driver, finger, solref="0.005 1"),
            Coupling(f"{_G}{side}_inner_knuckle_joint", _G + driver, knuckle, solref="0.005 1"),
        )
        for side, driver, finger, knuckle in sides
    )
    excluded = tuple(
        (f"{_G}{side}_inner_knuckle", f"{_G}{side}_{other}")
        for side in ("left", "right")
        for other in ("outer_knuckle", "inner_finger")
    )
    settings = (("damping", "0.1"), ("armature", "0.001"))
    limits = (("forcelimited", "true"), ("forcerange", f"-{force:g} {force:g}"))
    return Repair(
        why=(
            "The links of its Robotiq gripper are not coupled and run into each other; they follow "
            "the outer one, so that the pads stay parallel.",
        ),
        excluded_contacts=excluded,
        couplings=tuple(couplings),
        dropped_tendons=("_cpl",),
        attributes=(
            *(("joint", joint, *setting) for joint in _ROBOTIQ_JOINTS for setting in settings),
            *(("position", f"{_G}finger_{i}", *limit) for i in (1, 2) for limit in limits),
        ),
    )


ROBOTIQ_85 = Gripper(
    name="robotiq_85",
    stock_name="Robotiq85Gripper",
    joints=_ROBOTIQ_JOINTS,
    opened=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    closed=(0.8, -0.8, 0.8, 0.8, -0.8, 0.8),
    left_pads=_named("left_fingerpad_collision"),
    right_pads=_named("right_fingerpad_collision"),
    close_signs=(1.0, 1.0),
    repair=_parallel_jaw((-1, -1), (1, 1), force=1.0) + _grip_site(0.004),
)

ROBOTIQ_140 = Gripper(
    name="robotiq_140",
    stock_name="Robotiq140Gripper",
    joints=_ROBOTIQ_JOINTS,
    opened=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    closed=(0.69, 0.69, -0.69, -0.69, 0.69, -0.69),
    left_pads=_named("left_fingerpad_collision"),
    right_pads=_named("right_fingerpad_collision"),
    close_signs=(1.0, -1.0),
    pad_axis=2,
    repair=_parallel_jaw((1, -1), (-1, 1), force=2.0) + _grip_site(0.010),
)

_QUARTER_TURN = "0.7071067811865476 0 0 0.7071067811865476"  # about z, wxyz

XARM7_GRIPPER = Gripper(
    name="xarm7_gripper",
    stock_name="XArm7Gripper",
    joints=_named(
        *("left_driver_joint", "left_finger_joint", "left_inner_knuckle_joint"),
        *("right_driver_joint", "right_finger_joint", "right_inner_knuckle_joint"),
    ),
    opened=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    closed=(0.81, 0.81, 0.81, 0.81, 0.81, 0.81),
    left_pads=_named("left_finger_pad_1", "left_finger_pad_2"),
    right_pads=_named("right_finger_pad_1", "right_finger_pad_2"),
    close_signs=(1.0,),
    stock_knows_pads=False,  # it asks for geoms that its model lacks: nothing is ever grasped
    repair=Repair(
        why=(
            "Its gripper's grip site is turned by 90 degrees; its x axis is made the closing axis.",
            "The grasp check asks for pads that the model lacks; it is given those that there are.",
        ),
        attributes=(("site", f"{_G}grip_site", "quat", _QUARTER_TURN),),
    )
    + _grip_site(0.016),
)

_JACO_FINGERS = ("thumb", "index", "pinky")
_JACO_JOINTS = _named(*(f"joint_{f}{end}" for f in _JACO_FINGERS for end in ("", "_distal")))

JACO_HAND = Gripper(
    name="jaco_three_finger",
    stock_name="JacoThreeFingerGripper",
    joints=_JACO_JOINTS,
    opened=(0.95, 0.35) * 3,
    closed=(0.0, -0.6) * 3,
    left_pads=_named("index_pad_collision", "pinky_pad_collision"),
    right_pads=_named("thumb_pad_collision"),
    close_signs=(-1.0, -1.0, -1.0),
    stock_speed=0.01,  # 200 control steps from open to closed
    wrist_camera=Mount((0.1, 0.0, 0.05), 20.0),  # robosuite's sees the palm before what it holds
    repair=Repair(
        why=(
            "The hand takes 200 control steps to close; it takes ten.",
            "Its fingers have no inertia and are pulled to a length that they cannot reach, so "
            "that a contact throws a can 20 m away; the outer joints follow the inner ones, the "
            "thumb stands opposite the other two, and these together push as it does.",
        ),
        couplings=tuple(
            Coupling(f"{_G}joint_{f}_distal", f"{_G}joint_{f}", 1.0, 1.0) for f in _JACO_FINGERS
        ),
        dropped_tendons=("_cpl",),
        attributes=(
            *(("joint", joint, "armature", "0.001") for joint in _JACO_JOINTS),
            *(("joint", joint, "range", "-1 2") for joint in _JACO_JOINTS[1::2]),
            *(("position", _G + f, "ctrlrange", "0 0.95") for f in _JACO_FINGERS),
            *(
                ("position", _G + f, "forcerange", force)
                for f, force in zip(_JACO_FINGERS, ("-1 1", "-0.5 0.5", "-0.5 0.5"), strict=True)
            ),
            ("body", f"{_G}thumb_proximal", "quat", "0.96592583 0.25881905 0 0"),
        ),
    )
    + _grip_site(0.008),
)
