"""How good each episode is said to be, which are good, and a report read again."""

from __future__ import annotations

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from lfr import cli
from lfr.curation.finding import Finding
from lfr.curation.saved_report import read_report
from lfr.curation.scores import scores
from lfr.curation.verify import verify_dataset
from lfr.errors import LfrError

from .broken import BROKEN, EPISODES, cut, put


def run(*arguments: object) -> int:
    return cli.main(["verify", *map(str, arguments)])


def test_a_score_is_halved_by_each_kind_of_warning_and_gone_by_an_error() -> None:
    found = [
        Finding("jump", "a", "warning", episode=1),
        Finding("jump", "b", "warning", episode=1),
        Finding("noise", "c", "warning", episode=1),
        Finding("range", "d", "error", episode=1, episodes=(2, 3)),
        Finding("still", "e", "warning", episode=2),
        Finding("constant", "f", "warning"),
        Finding("counts", "g", episode=99),
    ]
    rated = scores(found, (5, 6, 7, 8))
    assert [one.score for one in rated] == [1.0, 0.25, 0.0, 0.0]
    assert [one.frames for one in rated] == [5, 6, 7, 8]
    assert [one.kinds for one in rated] == [(), ("jump", "noise"), ("range", "still"), ("range",)]


def test_the_table_of_scores(several: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(several, "--scores") == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["episode", "frames", "score", "kinds"]
    lengths = pq.read_table(several / EPISODES)["length"].to_pylist()
    rows = [line.split() for line in lines[1:18]]
    assert [(int(row[0]), int(row[1])) for row in rows] == list(enumerate(lengths))
    assert rows[7][2:] == ["0.25", "tasks,", "stuck"]
    assert rows[3][2:] == ["0.5", "tasks"]
    assert run(several, "--json") == 0
    content = json.loads(capsys.readouterr().out)
    assert content["scores"][7] == {
        "episode": 7, "frames": lengths[7], "score": 0.25, "kinds": ["tasks", "stuck"],
    }  # fmt: skip


def test_lerobot_reads_the_list_of_good_episodes(
    several: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the parser of `lerobot-train`, as text on its command line."""
    import draccus
    from lerobot.configs.train import TrainPipelineConfig

    assert run(several, "--good", "--min-score", "0.5") == 0
    printed = capsys.readouterr().out
    assert printed.endswith("]\n")
    arguments = ["--dataset.repo_id=a/b", f"--dataset.episodes={printed.rstrip()}"]
    config = draccus.parse(TrainPipelineConfig, args=arguments)
    assert config.dataset.episodes == [*range(7), *range(8, 16)]


def test_errors_of_the_whole_dataset_are_a_note_beside_the_list(
    dataset: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    BROKEN["frames miscounted"][0](dataset)
    BROKEN["an action beyond"][0](dataset)  # of episode 1
    assert run(dataset, "--good") == 0
    printed = capsys.readouterr()
    assert printed.out == "[0,2,3,4]\n"
    notes = [line for line in printed.err.splitlines() if line.startswith("note: ")]
    assert any("total_frames" in note for note in notes)
    assert not any("out of its range" in note for note in notes)
    assert run(dataset, "--good", "--fail-on", "error") == 1


def test_without_a_good_episode_there_is_no_list(
    dataset: Path, several: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An empty list, or none, could mean all of them to whoever reads it."""
    assert run(several, "--good") == 2
    printed = capsys.readouterr()
    assert (printed.out, "no episode of" in printed.err) == ("", True)
    cut(EPISODES, 0.5)(dataset)
    assert run(dataset, "--good") == 2
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("wrong", [["--min-score", "1"], ["--good", "--min-score", "nan"],
                                   ["--good", "--min-score", "2"]])  # fmt: skip
def test_a_score_that_means_nothing_is_refused(sound: Path, wrong: list[str]) -> None:
    assert run(sound, *wrong) == 2


@pytest.mark.parametrize("wrong", [None, -5, 10**9])
def test_lengths_that_are_none_still_give_scores(dataset: Path, wrong: int | None) -> None:
    put(EPISODES, "length", 2, wrong)(dataset)
    rated = verify_dataset(dataset).scores
    assert [one.episode for one in rated] == list(range(5))
    assert rated[0].frames == 12


def test_a_report_comes_back_from_its_json(several: Path, tmp_path: Path) -> None:
    report, file = verify_dataset(several), tmp_path / "report.json"
    file.write_text(json.dumps(report.as_json()))
    again = read_report(file)
    assert again.scores == report.scores
    assert [(f.check, f.episodes, f.frames, f.severity) for f in again.findings] == [
        (f.check, f.episodes, f.frames, f.severity) for f in report.findings
    ]
    for wrong in ("3", "{}", '{"findings": [], "accepted": [], "scores": [3]}', "x"):
        file.write_text(wrong)
        with pytest.raises(LfrError):
            read_report(file)
