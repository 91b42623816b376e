"""Names of what is observed."""

import pytest

from lfr.errors import UnknownNameError
from lfr.tasks import TASKS


@pytest.mark.parametrize(
    ("task", "size"), [("lift", 11), ("stack", 17), ("pick_place", 12), ("nut_assembly", 19)]
)
def test_sizes_and_places(task: str, size: int) -> None:
    layout = TASKS[task].observation
    assert len(layout.names[layout.state]) == 11
    assert len(layout.names[layout.environment]) == size
    assert len(set(layout.names)) == layout.size == 11 + size
    assert layout.names[layout.index("gripper_command")] == "gripper_command"
    first = next(iter(TASKS[task].objects))
    assert layout.slice(f"{first}_to_eef") == slice(17, 20)
    assert layout.slice("gripper_aperture") == slice(9, 10)


def test_unknown_names() -> None:
    layout = TASKS["lift"].observation
    with pytest.raises(UnknownNameError, match=r"cube_pos\.x"):
        layout.index("cube_pos")
    with pytest.raises(UnknownNameError, match="cube_yaw"):
        layout.slice("nut_yaw")
