"""`lfr diff` takes older versions and logs as they are, and finds in them what v3.0 would show."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import av
import pytest

from lfr import cli
from lfr.curation.diff.comparison import Comparison, compare_datasets, compare_leakage
from lfr.curation.diff.forms import as_dataset
from lfr.curation.diff.h264 import without_repeats
from lfr.curation.diff.packets import read_packets

from . import arm, older
from .broken import EPISODES, cut
from .test_diff import kinds, of_kind, the

COUNT = 5


@pytest.fixture(scope="module")
def old(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of v2.1, two episodes to a folder. Do not write to it."""
    folder = tmp_path_factory.mktemp("older") / "arm-reach"
    return older.write(folder, arm.recording(COUNT), size=2)


@pytest.fixture(scope="module")
def converted(old: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same as LeRobot's own converter makes it v3.0: one file of all rows, one long video."""
    from lerobot.scripts.convert_dataset_v21_to_v30 import convert_dataset

    theirs = shutil.copytree(old, tmp_path_factory.mktemp("converted") / "arm-reach")
    convert_dataset("local/theirs", root=theirs, push_to_hub=False)
    return theirs


def compare(a: Path, b: Path) -> Comparison:
    with as_dataset(a) as x, as_dataset(b) as y:
        return compare_datasets(x, y)


def test_a_conversion_differs_in_nothing(
    old: Path, converted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    oldest = older.write(tmp_path / "oldest", arm.recording(COUNT), version="v2.0")
    before = {p: p.stat().st_mtime_ns for p in old.rglob("*")}
    for a, b in ((old, converted), (converted, old), (oldest, converted), (oldest, old)):
        found = compare(a, b)
        assert (found.differences, found.same, found.not_compared) == ((), COUNT, ())
        assert (found.a, found.b) == (a, b)
    assert cli.main(["diff", str(old), str(converted)]) == 0
    last = f"A {old}, B {converted}: 5 and 5 episodes: 5 the same; nothing differs\n"
    assert capsys.readouterr().out == last
    assert {p: p.stat().st_mtime_ns for p in old.rglob("*")} == before


def test_what_else_changed_since_is_found(old: Path, converted: Path, tmp_path: Path) -> None:
    of = arm.recording(COUNT)
    of.states[1][3, 0] += 1
    of.pictures[3] = 255 - of.pictures[3]
    changed = older.write(tmp_path / "changed", of)
    older.change(changed / "meta/episodes.jsonl", lambda rows: rows[2].update(operator="ann"))
    found = compare(changed, converted)
    assert of_kind(found, "changed") == [(1, 1)]
    assert of_kind(found, "pictures") == [(3, 3)]
    assert the(found, "episode-column").column == "operator"
    assert kinds(found) <= {"changed", "pictures", "episode-column", "statistics"}


def test_an_older_one_leaks_too(old: Path, converted: Path) -> None:
    with as_dataset(old) as a:
        found = compare_leakage(a, converted)
    assert of_kind(found, "identical") == [(i, i) for i in range(COUNT)]
    assert found.a == old


def test_an_error_names_the_dataset_that_it_is_in(
    old: Path, converted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In that dataset's own names, whichever form the other one has."""
    new = shutil.copytree(converted, tmp_path / "new")
    cut(EPISODES, 0.5)(new)
    broken = shutil.copytree(old, tmp_path / "broken")
    (broken / "meta/episodes.jsonl").write_text('{"episode_index": 0')
    for a, b, said in ((old, new, f"{new}/{EPISODES}"), (new, old, f"{new}/{EPISODES}"),
                       (broken, converted, f"{broken}/meta/episodes.jsonl")):  # fmt: skip
        assert cli.main(["diff", str(a), str(b)]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert said in line


# H.264


def test_parameter_sets_of_the_setup_are_left_out_and_others_kept() -> None:
    setup = bytes([1, 100, 0, 10, 0xFF, 0xE1, 0, 4]) + b"\x67abc" + bytes([1, 0, 3]) + b"\x68de"
    own, picture = b"\0\0\0\x04\x67abc" + b"\0\0\0\x03\x68de", b"\0\0\0\x05\x65wxyz"
    other = b"\0\0\0\x04\x67abd"
    assert without_repeats(own + picture, setup) == picture
    assert without_repeats(other + picture, setup) == other + picture
    assert without_repeats(own + picture, b"\0\0\0\1" + setup) == own + picture
    for odd in (picture[:-2], picture + b"\0\0", picture + b"\0\0\0\0", b"\xff" * 9, b""):
        assert without_repeats(own + odd, setup) == odd


def test_a_file_that_ffmpeg_joined_has_the_packets_of_its_parts(old: Path, converted: Path) -> None:
    (joined,) = converted.rglob("*.mp4")
    with av.open(str(joined)) as container:
        packet = next(container.demux(video=0))
        assert bytes(packet)[4:].startswith(b"\x67") or b"\x67d\x00" in bytes(packet)
    parts = [read_packets(old / older.video(i, 2)).hashes for i in range(COUNT)]
    assert read_packets(joined).hashes.tolist() == [h for part in parts for h in part.tolist()]


# Logs


def test_logs_and_the_dataset_packed_from_them(
    sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = sound.parent.parent / "logs" / sound.name
    assert cli.main(["diff", str(logs), str(sound)]) == 0
    printed = capsys.readouterr().out
    assert printed == f"A {logs}, B {sound}: 5 and 5 episodes: 5 the same; nothing differs\n"
    some = shutil.copytree(logs, tmp_path / "some")
    sorted(some.iterdir())[2].unlink()
    found = compare(some, sound)
    assert of_kind(found, "added") == [(None, 2)]
    assert of_kind(found, "moved") == [(2, 3), (3, 4)]
    (one, *_) = sorted(some.iterdir())
    found = compare(one, sound)
    assert (found.episodes, found.same) == ((1, 5), 1)


def test_what_cannot_be_packed_is_one_line(
    sound: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    folder, place = tmp_path / "logs", tmp_path / "temporary"
    folder.mkdir()
    place.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    (folder / "a.mcap.partial").write_bytes(b"")
    for content, said in ((None, f"{folder}, found 1 unfinished"), (b"nothing", "a.mcap")):
        if content is not None:
            (folder / "a.mcap").write_bytes(content)
        assert cli.main(["diff", str(sound), str(folder)]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert said in line
        assert str(place) not in line
    assert not list(place.iterdir())
