"""Which of a scene's things touch each other, as robosuite's grasp and contact checks ask it."""

from __future__ import annotations

from lfr.compiled.arrays import Physics, SceneArrays
from lfr.compiled.marking import compiled

OTHER, LEFT_PAD, RIGHT_PAD, FIRST_OBJECT, SECOND_OBJECT = range(5)
"""What a geom is (`SceneArrays.geom_kind`)."""

MAX_CONTACTS = 200
"""Rows of the contact view; contacts beyond it exist in the physics, not in these checks."""


@compiled
def contacts(physics: Physics, scene: SceneArrays) -> tuple[bool, bool]:
    """Whether both pads touch the first object, and whether the two objects touch."""
    left = right = stacked = False
    for c in range(min(physics.contact_count[0], MAX_CONTACTS)):
        first, second = physics.contact_geoms[c, 0], physics.contact_geoms[c, 1]
        if first < 0 or second < 0:
            continue
        a, b = scene.geom_kind[first], scene.geom_kind[second]
        if a > b:
            a, b = b, a
        left |= a == LEFT_PAD and b == FIRST_OBJECT
        right |= a == RIGHT_PAD and b == FIRST_OBJECT
        stacked |= a == FIRST_OBJECT and b == SECOND_OBJECT
    return left and right, stacked
