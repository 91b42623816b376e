"""Several episodes as recordings of one application."""

from pathlib import Path

import numpy as np
import pytest
from rerun.experimental import RrdReader

from lfr.cli import main
from lfr.data.log_reader import list_logs, read_log
from lfr.view.collection import collection_of, save_episodes, shared_layout

from . import rrd
from .conftest import LOGS


def test_they_share_an_application_and_differ_in_identity(dataset: Path, tmp_path: Path) -> None:
    collection = collection_of(dataset)
    assert collection is not None
    files = save_episodes(collection, [0, 2], tmp_path)
    stores = [RrdReader(file).recordings()[0] for file in files]
    assert {store.application_id for store in stores} == {"panda-lift"}
    assert [store.recording_id for store in stores] == ["episode-0", "episode-2"]
    names = [rrd.read(file)["/__properties"]["RecordingInfo:name"][1][0][0] for file in files]
    assert names == [
        "0 success · seed 7 · panda · lift",
        "2 success · seed 11 · panda · lift",
    ]
    assert all(len(RrdReader(file).blueprints()) == 1 for file in files)


def test_each_holds_its_own_frames(dataset: Path, logs: Path, tmp_path: Path) -> None:
    collection = collection_of(dataset)
    assert collection is not None
    (file,) = save_episodes(collection, [1], tmp_path)
    episode = read_log(list_logs(logs)[1])
    found = rrd.rows(file, "/action/translation", "Scalars:scalars")
    np.testing.assert_array_equal(found, episode.features["action"][:, :3])


def test_a_folder_of_logs_is_a_collection_too(logs: Path) -> None:
    collection = collection_of(logs)
    assert collection is not None
    assert [entry.seed for entry in collection.entries()] == [seed for seed, _, _ in LOGS]
    episode, poses = collection.read(1)
    assert (episode.seed, len(episode)) == (3, 5)
    assert shared_layout([(episode, poses)]).title == "panda · lift"


def test_the_command_opens_the_ones_that_are_chosen(dataset: Path, tmp_path: Path) -> None:
    out = tmp_path / "two.rrd"
    assert main(["view", str(dataset), "--succeeded", "--save", str(out)]) == 0
    found = {store.recording_id for store in RrdReader(out).recordings()}
    assert found == {"episode-0", "episode-2"}


def test_none_as_wanted_is_said(
    dataset: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--length", "500-", "--save", str(tmp_path / "none.rrd")]
    assert main(["view", str(dataset), *arguments]) == 2
    assert "none of the 3 episodes" in capsys.readouterr().err
