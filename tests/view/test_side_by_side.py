"""Two recordings as one."""

from pathlib import Path

import numpy as np
import pytest

from lfr.cli import main
from lfr.view.pairing import parse_other

from . import rrd


def test_both_sides_are_the_recordings_themselves(
    dataset: Path, logs: Path, tmp_path: Path
) -> None:
    single = {}
    for number in (0, 2):
        out = tmp_path / f"{number}.rrd"
        assert main(["view", str(dataset), "--episode", str(number), "--save", str(out)]) == 0
        single[number] = rrd.read(out)
    pair = tmp_path / "pair.rrd"
    arguments = ["view", str(dataset), "--episode", "0", "--side-by-side", "2", "--save", str(pair)]
    assert main(arguments) == 0
    both = rrd.read(pair)
    for side, number in (("/left", 0), ("/right", 2)):
        for entity in ("/world/cube_main", "/action/translation", "/state/success"):
            for component, (frames, values) in single[number][entity].items():
                found, same = both[side + entity][component]
                np.testing.assert_array_equal(found, frames)
                assert same == values
    names = [both[f"{side}/reward"]["SeriesLines:names"][1][-1] for side in ("/left", "/right")]
    assert names == [["reward, left"], ["reward, right"]]


def test_another_dataset_answers_with_the_same_seed(
    dataset: Path, logs: Path, tmp_path: Path
) -> None:
    pair = tmp_path / "pair.rrd"
    arguments = ["--seed", "11", "--side-by-side", str(logs), "--save", str(pair)]
    assert main(["view", str(dataset), *arguments]) == 0
    title = rrd.read(pair)["/__properties"]["RecordingInfo:name"][1][0][0]
    assert title.count("2 success · seed 11 · panda · lift") == 2


def test_what_beside_names(tmp_path: Path) -> None:
    other, here = tmp_path / "other", tmp_path / "here"
    other.mkdir()
    assert parse_other("7", here) == (here, 7)
    assert parse_other(f"{other}:12", here) == (other, 12)
    assert parse_other(str(other), here) == (other, None)
    odd = tmp_path / "odd:3"
    odd.mkdir()
    assert parse_other(str(odd), here) == (odd, None)


def test_only_two_stand_side_by_side(
    dataset: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--episodes", "0-2", "--side-by-side", "1", "--save", str(tmp_path / "x.rrd")]
    assert main(["view", str(dataset), *arguments]) == 2
    assert "found 3 episodes" in capsys.readouterr().err
