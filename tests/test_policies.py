"""Episodes of policies on an arm that is one number; what names a policy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from lfr.errors import DataError
from lfr.policies import Outcome, Pinned, roll_out, run_episode
from tests.made_up_policies import Line, Steady


class Tiring:
    """Moves by 3, and by nothing from the third step since its last reset on."""

    def __init__(self) -> None:
        self.resets: list[int] = []

    def reset(self, seed: int) -> None:
        self.resets.append(seed)
        self.done = 0

    def act(self, observation: np.ndarray) -> np.ndarray:
        self.done += 1
        return np.full(1, 3.0 if self.done < 3 else 0.0)


class Counting(Steady):
    """Its actions rise from one answer to the next, so that each can be told."""

    def act(self, observation: np.ndarray) -> np.ndarray:
        return observation[0] + np.array([1.0, 2.0, 3.0])


def test_success_at_any_step_within_the_horizon_and_when() -> None:
    outcomes = roll_out(Steady(1.0), Line(), [4, 3, 9])
    assert outcomes == [Outcome(4, True, 8), Outcome(3, False, 8), Outcome(9, True, 3)]


def test_diverged_is_no_success() -> None:
    assert roll_out(Steady(2000.0), Line(), [0]) == [Outcome(0, False, 1)]


def test_every_episode_begins_with_a_reset() -> None:
    policy = Tiring()
    outcomes = roll_out(policy, Line(), [16, 17, 11])
    assert outcomes == [Outcome(16, True, 2), Outcome(17, True, 2), Outcome(11, False, 8)]
    assert policy.resets == [16, 17, 11]


@pytest.mark.parametrize(("linger", "end"), [(0, 1), (1, 2), (4, 5), (50, 8)])
def test_an_episode_lingers_after_success_and_says_when_that_was(linger: int, end: int) -> None:
    line = Line()
    assert run_episode(Steady(3.0), line, 9, linger) == Outcome(9, True, 1)
    assert line.at == 9 + 3 * end


def test_what_success_interrupts_is_carried_out() -> None:
    line = Line()
    run_episode(Counting(0.0), line, 9, linger=2)  # from 9: success after 10 + ...
    assert line.at == 9 + 10 + 11 + 12


@dataclass(frozen=True)
class Stored:
    folder: str
    other: str | None = None

    def load(self, robot: str) -> Steady:
        return Steady(float((Path(self.folder) / "speed").read_text()))


def test_another_policy_in_the_folder_has_another_name(tmp_path: Path) -> None:
    (tmp_path / "speed").write_text("1")
    source = Stored(str(tmp_path))
    before = Pinned.of(source)
    assert before == Pinned.of(source)
    (tmp_path / "speed").write_text("2")
    assert Pinned.of(source) != before
    assert before.load("panda") == Steady(2.0)
    with pytest.raises(DataError, match="missing"):
        Pinned.of(Stored(str(tmp_path / "nothing")))
