"""Where an arm departs from robosuite's, for the limits of a card."""

from __future__ import annotations

from lfr.robots import Robot


def departures(robot: Robot) -> list[str]:
    """A line for each repair of a robosuite model; numbers from stock are not comparable then."""
    return [
        f"{robot.title} departs from stock robosuite: {why[0].lower()}{why[1:]} Numbers from "
        "there are not comparable."
        for why in robot.repairs.why
    ]
