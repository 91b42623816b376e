"""The benchmarks of data and training, on little of everything."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import torch

from benchmarks import cameras, importing_bags, packing, simulation, stages, training
from benchmarks import windows as reading
from benchmarks._datasets import Size, as_of_robot, write_dataset
from benchmarks._figures import FOLDER, within
from lfr.artifacts import read_json
from lfr.data.checks import check_dataset
from lfr.data.episode import Episode
from lfr.data.log_reader import read_log
from lfr.data.windows import Windows, read_dataset
from lfr.errors import DataError
from lfr.evaluation.marked import put, shown
from lfr.jobs import Job
from lfr.jobs.memory import own_peak
from lfr.sim.camera import camera_available
from tests.data import made_up

FEW = Size(episodes=3, shortest=12, longest=20)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("made-up") / "panda-lift"
    write_dataset(path, FEW)
    return path


def test_amounts_are_parts_of_the_most_that_they_may_be() -> None:
    figure = within("memory", "GiB", 2.0, [1.0, 3.0, 1.5])
    assert (figure.ratio, figure.spread, figure.reached) == (0.75, (0.5, 1.5), True)
    assert (figure.ours, figure.theirs) == (1.5, 2.0)
    assert not within("memory", "GiB", 2.0, [2.1]).reached


def test_a_made_up_bag_is_as_large_as_it_is_to_be_and_is_imported(tmp_path: Path) -> None:
    figure, holds = importing_bags.measure(0.01, 5, tmp_path)
    assert 10e6 <= holds["bytes"] < 11e6
    assert 150e3 < holds["bytes"] / holds["pictures"] < 300e3
    # as many frames as fit, but for the last, whose action would be the frame after it
    frames = int(holds["seconds"] * 5)
    assert (holds["total_episodes"], holds["total_frames"]) == (1, frames)
    assert figure.reached
    assert figure.ours > 100


def test_the_same_rows_as_another_arms(dataset: Path, tmp_path: Path) -> None:
    other = tmp_path / "sawyer-lift"
    as_of_robot(dataset, other, "sawyer")
    check_dataset(other, robot="sawyer", task="lift")
    check_dataset(dataset, robot="panda", task="lift")
    with pytest.raises(DataError, match="another robot"):
        check_dataset(other, robot="panda")
    assert torch.equal(read_dataset(other).actions, read_dataset(dataset).actions)


def test_other_windows_are_found_out(dataset: Path) -> None:
    from lerobot.datasets import LeRobotDataset

    timestamps = {"action": [t / 20 for t in range(4)]}
    theirs = LeRobotDataset(
        "lfr/panda-lift", dataset, delta_timestamps=timestamps, video_backend="pyav"
    )
    known = read_dataset(dataset)
    reading.check_same(Windows(known, 4, padded=True), theirs)
    other = dataclasses.replace(known, actions=known.actions + 1e-6)
    with pytest.raises(AssertionError, match="another action"):
        reading.check_same(Windows(other, 4, padded=True), theirs)


def test_both_sides_pack_the_same_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    logs = made_up.write_all(tmp_path / "logs", (12, 9))
    seconds = packing.one_round(logs, tmp_path, theirs_first=True)
    assert min(dataclasses.astuple(seconds)) > 0
    right = packing.frames_of

    def wrong(episode: Episode) -> packing.Frames:
        frames = right(episode)
        frames[0]["action"] = np.zeros_like(frames[0]["action"])
        return frames

    monkeypatch.setattr(packing, "frames_of", wrong)
    with pytest.raises(AssertionError, match="other rows"):
        packing.one_round(logs, tmp_path / "again", theirs_first=False)


@pytest.mark.slow
def test_a_jobs_peak_is_its_own() -> None:
    held = np.ones(2**26)  # 512 MiB
    assert training.peak() < own_peak() - held.nbytes / 2
    assert training.peak(Job(np.ones, 2**26)) > held.nbytes


@pytest.mark.slow
def test_all_figures(dataset: Path, tmp_path: Path) -> None:
    read = reading.measure(dataset, 10, (8,), repeats=1)
    assert [figure.name for figure in read] == ["getitem/batch_8", "dataloader_2_workers/batch_8"]
    packed = packing.measure(made_up.write_all(tmp_path / "logs", (12, 9)), tmp_path, repeats=1)
    # the logs are read besides, so the second ratio is at least as large
    assert packed[0].ratio < packed[1].ratio
    trained = training.measure(tmp_path / "training", episodes=20, steps=2)
    assert len(trained) == 3
    assert all(0.05 < figure.ours < 2 for figure in trained)


@pytest.mark.skipif(not camera_available(), reason="no OpenGL (libegl1)")
def test_more_cameras_are_more_to_record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cameras, "SIZE", 32)
    monkeypatch.setattr(cameras, "NAMES", ("agentview", "wrist"))
    figures = cameras.costs(tmp_path, repeats=1)
    assert len(figures) == 2 * 3
    assert all(figure.ratio > 0 for figure in figures)
    for one, two in (figures[2:4], figures[4:6]):  # the sizes, which are the same on any machine
        assert two.ratio < one.ratio < 1
    states = read_log(next(tmp_path.rglob("*.mcap"))).simulator_state[:2]
    assert [figure.unit for figure in cameras.drawing(states, 1)] == ["pictures/s"] * 4


def test_a_page_shows_what_was_put_there(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- a -->\nold\n<!-- /a -->\n<!-- b -->\nb\n<!-- /b -->\nafter\n")
    put(page, "a", "new\nlines")
    assert (shown(page, "a"), shown(page, "b")) == ("new\nlines", "b")
    assert page.read_text().startswith("before\n")
    assert page.read_text().endswith("after\n")


def test_the_page_shows_the_engines_ratios() -> None:
    figures = read_json(FOLDER / "simulation.json")["figures"]
    assert shown(simulation.PAGE, simulation.MARKER) == simulation.table(figures)
    bare = [figure for figure in figures if figure["name"].startswith("mj_step/")]
    assert len(bare) == len(simulation.COMBINATIONS)
    assert all(figure["reached"] for figure in bare)


def test_a_stages_costs_against_before_and_in_yardsticks() -> None:
    now, before = stages.Cost(30.0, 15.0, 1.5), stages.Cost(100.0, 50.0, 2.0)
    memory, ratio, unit = stages.figures_of("skills", [[now, before], [now, before]])
    assert (memory.ours, memory.reached) == (1.5, True)
    assert (ratio.ratio, ratio.ours, ratio.theirs, ratio.reached) == (0.3, 30.0, 100.0, True)
    assert (unit.ratio, unit.theirs) == (15.0, 2.0)
    slow = stages.figures_of("skills", [[before, now]])[1]
    assert not slow.reached
    assert [figure.name for figure in stages.figures_of("transfer", [[now]])] == [
        "memory/transfer", "yardstick/transfer"
    ]  # fmt: skip
