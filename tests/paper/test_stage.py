"""Seeds and judging of the evidence: what they may be."""

from __future__ import annotations

import pytest

from lfr.errors import ParameterError
from lfr.params import from_mapping
from pipeline.paper._stage import Judging, PaperSeeds


@pytest.mark.parametrize(
    ("tables", "questions", "message"),
    [
        ([], [0, 1], "tables must name each seed once"),
        ([0, 0, 1], [0, 1], "tables must name each seed once"),
        ([0, 1], [1, 1], "questions must name each seed once"),
        ([0], [0], "tables must name two seeds or more"),
        ([0, 1], [1, 2], "and questions some of them"),
    ],
)
def test_seeds_that_do_not_fit(tables: list[int], questions: list[int], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        from_mapping(PaperSeeds, {"tables": tables, "questions": questions}, "seeds")


def test_each_seed_leads_to_another_and_all_of_them_in_a_circle() -> None:
    seeds = PaperSeeds(tables=(3, 5, 7, 9), questions=(3, 9, 5))
    assert [seeds.after(seed) for seed in seeds.tables] == [5, 7, 9, 3]
    # One more question changes nobody's next seed.
    assert seeds.after(5) == PaperSeeds(seeds.tables, (5,)).after(5)


@pytest.mark.parametrize("changed", ["episodes", "stock_episodes"])
def test_somebody_has_to_be_judged(changed: str) -> None:
    with pytest.raises(ParameterError, match=r"at least 1, found .*0"):
        from_mapping(Judging, {"episodes": 4, "stock_episodes": 2, changed: 0}, "judging")
