"""The list of episodes, against the logs that they were packed from."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lfr.cli import main
from lfr.data.log_reader import list_logs, read_log
from lfr.view.listing import dataset_entries, log_entries

from .conftest import LOGS


def test_a_datasets_list_is_what_its_logs_hold(dataset: Path, logs: Path) -> None:
    entries = dataset_entries(dataset)
    episodes = [read_log(path) for path in list_logs(logs)]
    assert [entry.index for entry in entries] == [0, 1, 2]
    for entry, episode, (seed, frames, won) in zip(entries, episodes, LOGS, strict=True):
        assert (entry.seed, entry.length, entry.success) == (seed, frames, won)
        assert entry.reward == pytest.approx(float(np.sum(episode.features["next.reward"])))


def test_a_folder_of_logs_has_the_same_list(dataset: Path, logs: Path) -> None:
    found = log_entries(list_logs(logs))
    plain = [replace(entry, note="", reward=None) for entry in found]
    assert plain == [replace(entry, reward=None) for entry in dataset_entries(dataset)]
    rewards = [entry.reward for entry in dataset_entries(dataset)]
    assert [entry.reward for entry in found] == pytest.approx(rewards, rel=1e-6)


def test_a_cut_off_log_does_not_hide_the_others(logs: Path, tmp_path: Path) -> None:
    whole, cut = (tmp_path / f"episode-{n:06d}.mcap" for n in (0, 1))
    content = list_logs(logs)[0].read_bytes()
    whole.write_bytes(content)
    cut.write_bytes(content[:-200])
    first, second = log_entries([whole, cut])
    assert first.length == LOGS[0][1]
    assert "cut-off" in second.note


def test_the_command_prints_what_is_chosen(
    dataset: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["view", str(dataset), "--list", "--sort", "length"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["episode", "0", "2", "1", "3"]
    assert lines[1].split()[1:] == ["12", "0.60", "yes", "6.600", "7"]
    assert lines[-1] == "3 episodes, 2 succeeded, 26 frames, 1 s"
    assert main(["view", str(dataset), "--list", "--failed"]) == 0
    assert capsys.readouterr().out.splitlines()[1].split()[0] == "1"


def test_what_has_no_episodes_cannot_be_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["view", str(tmp_path), "--list"]) == 2
    assert "no episodes to list" in capsys.readouterr().err
