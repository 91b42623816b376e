"""In contact the engine is held to stock robosuite by distribution."""

import pytest

from benchmarks.agreement import compare
from lfr.tasks import TASKS

ARMS = ("panda", "sawyer", "iiwa", "kinova3", "ur5e")
HELD = [f"{arm}{controller}" for arm in ARMS for controller in ("", "-joint_position")]


def test_the_same_episodes_agree() -> None:
    found = compare("panda", "lift", seeds=4)
    assert found.successes == (4, 4)
    assert found.alike == 4
    assert found.object_apart[1] < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("name", HELD)
def test_no_distribution_differs_over_100_starts(name: str, task: str) -> None:
    found = compare(name, task, seeds=100)
    # Five tests for each of 40 combinations: a false alarm once in 50 runs.
    assert found.smallest_p > 1e-4, found
    assert found.alike >= 90
