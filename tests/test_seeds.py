"""No seed has two uses."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lfr.errors import LfrError
from lfr.seeds import FIRST, PER_USE, Use, episode_seed, use_of_seed

uses = st.sampled_from(sorted(FIRST))
indices = st.integers(0, PER_USE - 1)


@given(uses, indices, uses, indices)
def test_ranges_do_not_meet(one: Use, i: int, other: Use, j: int) -> None:
    same = episode_seed(one, i) == episode_seed(other, j)
    assert same == ((one, i) == (other, j))
    assert use_of_seed(episode_seed(one, i)) == one


@pytest.mark.parametrize("index", [-1, PER_USE])
def test_an_index_outside_the_range(index: int) -> None:
    with pytest.raises(LfrError, match=f"index {index} of learning seeds; expected 0 to 999999"):
        episode_seed("learning", index)


def test_a_seed_of_no_use() -> None:
    with pytest.raises(LfrError, match="seed 3000000 is in no range"):
        use_of_seed(3_000_000)
