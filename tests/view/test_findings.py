"""The findings of a dataset in its episodes: where they are logged, which episodes are opened."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from lfr.cli import main
from lfr.curation.finding import Finding
from lfr.curation.verify import Report, verify_dataset
from lfr.view.findings import Findings
from lfr.view.recordings import Wanted, recordings
from lfr.view.selection import Selection

from ..curation import arm
from ..curation.test_behaviour import FAULTS
from . import rrd

EPISODES = 9


@pytest.fixture(scope="module")
def faulty(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nine episodes of an arm, 7 with a spike."""
    of = arm.recording(EPISODES)
    FAULTS["a spike"][0](of)
    return arm.write(tmp_path_factory.mktemp("faulty") / "arm", of)


@pytest.fixture(scope="module")
def report(faulty: Path) -> Report:
    """As it is verified, with findings added whose frames and words are known."""
    found = verify_dataset(faulty)
    start = sum(found.lengths[:4])
    more = (
        Finding("stuck", "does not move ![x](http://a/b.png)", "warning", "data", 4,
                "observation.state: elbow.pos", start + 20, frames=(20, 44)),
        Finding("not-finite", "NaN", "error", "data", 4, "action", start + 33, places=2,
                episodes=(4, 6)),
        Finding("counts", "of no episode", "error"),
    )  # fmt: skip
    return Report(faulty, (*found.findings, *more), found.episodes, found.frames,
                  lengths=found.lengths)  # fmt: skip


@pytest.fixture(scope="module")
def saved(report: Report, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("saved") / "verify.json"
    file.write_text(json.dumps(report.as_json()))
    return file


def test_the_worst_are_opened_first_and_no_others(
    faulty: Path, report: Report, tmp_path: Path
) -> None:
    wanted = Wanted(Selection(findings=True, order="score"), findings=Findings(report))
    assert recordings(faulty, tmp_path, wanted).numbers == (4, 6, 7)


def test_each_finding_is_logged_at_its_frames(faulty: Path, saved: Path, tmp_path: Path) -> None:
    out = tmp_path / "episode.rrd"
    command = ["view", str(faulty), "--findings", str(saved), "--episode", "4", "--save", str(out)]
    assert main(command) == 0
    shown = rrd.read(out)
    frames, texts = shown["/findings"]["TextLog:text"]
    _, levels = shown["/findings"]["TextLog:level"]
    assert frames is not None
    assert frames.tolist() == [20, 33, 44]
    assert [level[0] for level in levels] == ["WARN", "ERROR", "WARN"]
    assert texts[0][0].startswith("frame 20: stuck: does not move")
    assert "elbow.pos" in texts[0][0]
    assert texts[2][0] == "frame 44: stuck: since frame 20"
    document = shown["/findings/list"]["TextDocument:text"][1][0][0]
    assert document.startswith("# Episode 4: score 0\n")
    assert "`does not move ![x](http://a/b.png)`" in document  # in code nothing is fetched
    assert "at 1.00 s to 2.20 s" in document


def test_what_is_about_no_frame_of_the_episode_is_at_its_beginning(
    faulty: Path, saved: Path, tmp_path: Path
) -> None:
    """The second episode that a finding names, and one that names no frames."""
    out = tmp_path / "episode.rrd"
    command = ["view", str(faulty), "--findings", str(saved), "--episode", "6", "--save", str(out)]
    assert main(command) == 0
    frames, texts = rrd.read(out)["/findings"]["TextLog:text"]
    assert frames is not None
    assert frames.tolist() == [0]
    assert texts[0][0].startswith("not-finite: NaN")


def test_without_a_file_the_dataset_is_verified(faulty: Path, tmp_path: Path) -> None:
    out = tmp_path / "episode.rrd"
    assert main(["view", str(faulty), "--findings", "--save", str(out)]) == 0
    shown = rrd.read(out)
    frames, texts = shown["/findings"]["TextLog:text"]
    assert frames is not None
    assert {30, 31} <= set(frames.tolist())
    assert any("jump: a single row" in text[0] for text in texts)
    assert shown["/findings/list"]["TextDocument:text"][1][0][0].startswith("# Episode 7: ")


def test_an_episode_without_findings_says_so(faulty: Path, saved: Path, tmp_path: Path) -> None:
    out = tmp_path / "episode.rrd"
    command = ["view", str(faulty), "--findings", str(saved), "--episode", "0", "--save", str(out)]
    assert main(command) == 0
    shown = rrd.read(out)
    assert "/findings" not in shown
    assert "Nothing is found" in shown["/findings/list"]["TextDocument:text"][1][0][0]


def test_the_list_has_scores_and_kinds(
    faulty: Path, saved: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["view", str(faulty), "--list", "--findings", str(saved)]
    assert main(command) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == [
        "episode", "frames", "seconds", "success", "reward", "seed", "score", "kinds",
    ]  # fmt: skip
    assert lines[5].split()[6:] == ["0", "stuck,", "not-finite"]
    assert lines[1].split()[6:] == ["1"]
    assert main([*command, "--sort", "score", "--first", "2"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()[1:3]] == ["4", "6"]
    assert main(["view", str(faulty), "--list"]) == 0
    assert "score" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--sort", "score"], "needs --findings"),
        (["--findings", "{saved}", "--side-by-side", "1"], "not side by side"),
        (["--findings", "absent.json"], "the file is missing"),
        (["--list", "--sort", "score"], "needs --findings"),
    ],
)
def test_what_does_not_go_together_is_one_line(
    faulty: Path,
    saved: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    said: str,
) -> None:
    named = [argument.format(saved=saved) for argument in arguments]
    assert main(["view", str(faulty), *named, "--save", str(tmp_path / "x.rrd")]) == 2
    error = capsys.readouterr().err.strip()
    assert said in error
    assert len(error.splitlines()) == 1


def test_findings_of_another_dataset_are_refused(
    faulty: Path, report: Report, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "other.json"
    content = report.as_json()
    content["scores"] = content["scores"][:-1]
    other.write_text(json.dumps(content))
    assert main(["view", str(faulty), "--list", "--findings", str(other)]) == 2
    assert "another dataset" in capsys.readouterr().err
    (tmp_path / "logs").mkdir()
    assert main(["view", str(tmp_path / "logs"), "--findings", "--save", "x.rrd"]) == 2
    assert "are of a dataset" in capsys.readouterr().err


def test_where_nothing_is_found_nothing_is_opened(
    faulty: Path, report: Report, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "none.json"
    file.write_text(json.dumps({**report.as_json(), "findings": []}))
    command = ["view", str(faulty), "--findings", str(file), "--save", str(tmp_path / "x.rrd")]
    assert main(command) == 2
    assert "nothing is found in any of the 9 episodes" in capsys.readouterr().err
