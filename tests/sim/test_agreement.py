"""In contact the engine is held to stock robosuite by distribution."""

import pytest

from benchmarks.agreement import compare
from tests.sim.pairs import COMBINATIONS


def test_the_same_episodes_agree() -> None:
    found = compare("panda", "lift", seeds=4)
    assert found.successes == (4, 4)
    assert found.alike == 4
    assert found.object_apart[1] < 0.01


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "task"), COMBINATIONS)
def test_no_distribution_differs_over_100_starts(robot: str, task: str) -> None:
    found = compare(robot, task, seeds=100)
    # Five tests for each of eight combinations: a false alarm once in 250 runs.
    assert found.smallest_p > 1e-4, found
    assert found.alike >= 90
