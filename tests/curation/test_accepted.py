"""What makes `lfr verify` fail, and which findings are known and set aside."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path

import pytest

from lfr import cli
from lfr.curation.accepted import accept, read_accepted
from lfr.curation.fail_on import FailOn
from lfr.curation.finding import Finding
from lfr.curation.kinds import KINDS
from lfr.curation.verify import Report

from .broken import BROKEN
from .test_behaviour import FAULTS, PICTURES


def run(*arguments: object) -> int:
    return cli.main(["verify", *map(str, arguments)])


def test_every_kind_that_a_check_names_is_known() -> None:
    """Of all text that stands as a finding's first argument, or is handed on as its check."""
    root = Path(__file__).parents[2] / "lfr/curation"
    named = {check for _, check, *_ in (*BROKEN.values(), *FAULTS.values(), *PICTURES.values())}
    for file in root.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                first = {"Finding": 0, "unreadable": 0, "warning": 3}.get(node.func.id)
                if first is not None and len(node.args) > first:
                    value = node.args[first]
                    if isinstance(value, ast.Constant):
                        named.add(value.value)
    assert len(named) > 45
    assert named <= set(KINDS)
    assert set(KINDS) - named <= {"averaged-quantiles", "time-start", "frame-index", "index"}


@pytest.mark.parametrize(
    ("text", "fails"),
    [
        ("error", [True, False, False]),
        ("warning", [True, True, False]),
        ("none", [False, False, False]),
        ("stuck", [False, True, False]),
        ("jump,range", [True, False, False]),
        ("error, stuck", [True, True, False]),
        ("none,stuck", [False, True, False]),
    ],
)
def test_what_fails(text: str, fails: list[bool]) -> None:
    reports = [[Finding("range", "x")], [Finding("stuck", "x", "warning")], []]
    assert [FailOn.parse(text).fails(found) for found in reports] == fails


def test_the_exit_code_is_what_was_asked_for(
    several: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(several) == 0
    assert run(several, "--fail-on", "warning") == 1
    assert run(several, "--fail-on", "stuck,jump") == 1
    assert run(several, "--fail-on", "jump") == 0
    capsys.readouterr()
    assert run(several, "--fail-on", "stuk") == 2
    said = capsys.readouterr().err.strip()
    assert len(said.splitlines()) == 1
    assert "stuk" in said
    assert "error, warning, none" in said
    assert "duplicate" in said


def test_accepted_findings_are_set_aside_and_counted(
    several: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    known = tmp_path / "known.yaml"
    known.write_text(
        "- {check: duplicate, episode: 16}\n"
        '- {check: stuck, column: "observation.state: elbow.pos"}\n'
        "- check: spike\n- {check: stuck, episode: 3}\n"
    )
    assert run(several, "--fail-on", "duplicate,stuck", "--accept", known) == 0
    lines = capsys.readouterr().out.splitlines()
    assert not any("duplicate:" in line or "stuck:" in line for line in lines)
    assert re.search(r"no errors, 2 warnings, 3 accepted", lines[-1])
    assert lines[-2].endswith("nothing matches any more: spike; stuck, episode 3")


def test_what_json_printed_is_accepted_whole(
    several: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(several, "--json") == 0
    known = tmp_path / "known.json"
    known.write_text(capsys.readouterr().out)
    assert run(several, "--fail-on", "warning", "--accept", known, "--json") == 0
    content = json.loads(capsys.readouterr().out)
    assert content["findings"] == []
    assert len(content["accepted"]) == 5
    assert content["unmatched"] == ""
    # and again, of a report in which they were accepted already
    known.write_text(json.dumps(content))
    assert run(several, "--fail-on", "warning", "--accept", known) == 0
    assert "no warnings, 5 accepted" in capsys.readouterr().out


def test_a_finding_that_names_one_episode_more_is_new(tmp_path: Path) -> None:
    before = Finding("jump-in-time", "m", file="f", column="c", episode=3, episodes=(3, 4))
    after = Finding("jump-in-time", "m", file="f", column="c", episode=3, episodes=(3, 4, 9))
    whole = Finding("unit", "m", "warning", file="data", column="c")
    of_one = Finding("unit", "m", "warning", file="data", column="c", episode=2)
    file = tmp_path / "known.json"
    old = Report(tmp_path, (before, whole))
    file.write_text(json.dumps(old.as_json()))
    new = accept(Report(tmp_path, (after, whole, of_one)), read_accepted(file), file)
    assert (new.findings, new.accepted) == ((after, of_one), (whole,))
    file.write_text("[{check: jump-in-time, episode: [3, 4]}, {check: jump-in-time, episode: 9}]")
    assert accept(new, read_accepted(file), file).findings == (of_one,)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("[{check: constant, colum: a}]", r"'colum'; valid: check, episode, column, file"),
        ("[{check: constat}]", r"'constat'; valid: damaged-file, "),
        ("[{column: a}]", "entry 1 has no check"),
        ("[{check: constant}, 3]", "entry 2 is no mapping"),
        ("[{check: constant, episode: x}]", "episode is no whole number"),
        ("[{check: constant, episode: true}]", "episode is no whole number"),
        ("[{check: constant, episode: []}]", "episode is no whole number"),
        ("[{check: constant, column: 3}]", "column is no text"),
        ("{check: constant}", "no accepted findings"),
        ("3", "no accepted findings"),
        ("[", "cannot be read"),
        ("[" * 100_000, "cannot be read"),
        ("!!python/object:os.system {}", "cannot be read"),
        (b"\xff\xfe\x00", "cannot be read"),
        ('{"findings": [3]}', "no finding"),
        ('{"findings": [{"check": 3}]}', "no finding"),
        ('{"findings": [{"check": "x", "severity": "error", "episodes": ["a"]}]}', "no finding"),
        ('{"findings": 3}', "no accepted findings"),
        (None, "the file is missing"),
    ],
)
def test_a_wrong_file_of_accepted_findings_is_one_line(
    sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], content: object, said: str
) -> None:
    file = tmp_path / "known"
    if isinstance(content, bytes):
        file.write_bytes(content)
    elif content is not None:
        file.write_text(str(content))
    assert run(sound, "--accept", file) == 2
    error = capsys.readouterr().err.strip()
    assert re.search(said, error), error
    assert len(error.splitlines()) == 1


def test_an_empty_file_accepts_nothing(sound: Path, tmp_path: Path) -> None:
    (tmp_path / "none.yaml").write_text("# nothing yet\n")
    assert read_accepted(tmp_path / "none.yaml") == []
    assert run(sound, "--accept", tmp_path / "none.yaml") == 0
