"""The benchmark of the simulation, on little of everything."""

from pathlib import Path

import pytest

from benchmarks import simulation as benchmark
from benchmarks._figures import Figure, compare, write
from lfr.artifacts import read_json
from lfr.sim.simulation import simulation


def test_a_ratio_is_the_median_of_the_repeats_ratios(tmp_path: Path) -> None:
    ours, theirs = iter([99, 8.0, 6.0, 10.0]), iter([99, 2.0, 1.0, 5.0])
    figure = compare("a", "1/s", 3.0, lambda: next(ours), lambda: next(theirs), 3)
    assert (figure.ratio, figure.spread) == (4.0, (2.0, 6.0))
    assert (figure.ours, figure.theirs, figure.reached) == (8.0, 2.0, True)
    memory = Figure("b", "MB", 60.0, 50.0, (60.0, 60.0), 1.0, 1.0, at_most=True)
    content = read_json(write("some", [figure, memory], tmp_path))
    assert [row["reached"] for row in content["figures"]] == [True, False]
    assert content["figures"][0]["goal"] == 3.0
    assert "mujoco" in content["made_with"]["packages"]


def test_a_demonstration_succeeds_and_bare_mj_step_follows_it() -> None:
    engine = simulation("panda", "lift")
    actions = benchmark.demonstration(engine, 150)
    assert len(actions) % benchmark.SKILL == 0
    assert 20 <= len(actions) < 150
    torques = benchmark.controls(engine, actions)
    benchmark.check_same_trajectory(engine, actions, torques)
    with pytest.raises(AssertionError):
        benchmark.check_same_trajectory(engine, actions, 0.9 * torques)


@pytest.mark.slow
def test_all_figures_of_one_combination() -> None:
    figures = benchmark.measure([("panda", "stack")], steps=20, repeats=1, environments=3)
    names = {figure.name.split("/")[0] for figure in figures}
    assert names == {"stock", "mj_step", "reset", "two cores", "threads", "memory"}
    assert all(figure.ratio > 0 for figure in figures)
