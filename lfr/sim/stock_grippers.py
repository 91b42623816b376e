"""What is mended in robosuite's classes of grippers, beside their models (`lfr.robots.repair`)."""

from __future__ import annotations

from lfr.robots import Gripper


def mend_gripper(gripper: Gripper) -> None:
    """Have robosuite's class of a gripper move at our speed and ask for pads that exist."""
    from robosuite.models.grippers import GRIPPER_MAPPING

    known = GRIPPER_MAPPING[gripper.stock_name]
    if gripper.speed != gripper.stock_speed:
        known.speed = property(lambda self: gripper.speed)
    if not gripper.stock_knows_pads:
        pads = {
            f"{side}_{part}": [name.removeprefix("gripper0_right_") for name in names]
            for side, names in (("left", gripper.left_pads), ("right", gripper.right_pads))
            for part in ("finger", "fingerpad")
        }
        known._important_geoms = property(lambda self: pads)
