"""Which episodes are kept, and in which order."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lfr.errors import LfrError
from lfr.view.selection import Entry, Ranges, Selection

ENTRIES = [
    Entry(0, 40, True, 5.0, 7),
    Entry(1, 90, False, None, 3),
    Entry(2, 60, True, 9.0, None),
    Entry(3, 60, None, 1.0, 4),
]


def kept(**selection: object) -> list[int]:
    return [entry.index for entry in Selection(**selection).apply(ENTRIES)]  # type: ignore[arg-type]


@given(st.lists(st.tuples(st.integers(0, 50), st.integers(0, 50)), min_size=1), st.integers(0, 60))
def test_ranges_hold_what_they_list(bounds: list[tuple[int, int]], number: int) -> None:
    pairs = [(min(pair), max(pair)) for pair in bounds]
    text = ",".join(str(low) if low == high else f"{low}-{high}" for low, high in pairs)
    every = {n for low, high in pairs for n in range(low, high + 1)}
    assert (number in Ranges.parse(text)) == (number in every)


def test_a_range_may_be_open() -> None:
    assert Ranges.parse("40-,-3").bounds == ((40.0, math.inf), (0.0, 3.0))
    assert None not in Ranges.parse("0-")


@pytest.mark.parametrize("text", ["", "-", "a", "3..5", "9-3", "1,,2", "1.5"])
def test_no_list_of_numbers(text: str) -> None:
    with pytest.raises(ValueError, match="found"):
        Ranges.parse(text)


def test_filters() -> None:
    assert kept() == [0, 1, 2, 3]
    assert kept(success=False) == [1]  # an unknown outcome is no failure
    assert kept(success=True) == [0, 2]
    assert kept(seeds=Ranges.parse("3-4")) == [1, 3]
    assert kept(lengths=Ranges.parse("60-")) == [1, 2, 3]
    assert kept(episodes=Ranges.parse("0,2-"), success=True) == [0, 2]


def test_order() -> None:
    assert kept(order="length") == [1, 2, 3, 0]
    assert kept(order="length", reverse=True) == [0, 2, 3, 1]
    assert kept(order="reward") == [2, 0, 3, 1]  # what is not known comes last
    assert kept(order="reward", reverse=True) == [3, 0, 2, 1]
    assert kept(order="seed") == [1, 3, 0, 2]
    assert kept(order="length", first=2) == [1, 2]


def test_one_number_needs_no_list() -> None:
    one = Ranges.parse("7")
    assert Selection(episodes=one).number == 7
    assert Selection(episodes=one, success=True).number is None
    assert Selection(episodes=Ranges.parse("7-8")).number is None
    assert Selection().number is None


def test_a_number_that_is_not_there() -> None:
    with pytest.raises(LfrError, match="no episode 9; expected 0 to 3"):
        kept(episodes=Ranges.parse("2-9"))
