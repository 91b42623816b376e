"""LeRobot v2.1 and v2.0 are read as they are: the same rows, and the same faults found."""

from __future__ import annotations

import itertools
import json
import re
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from lfr import cli
from lfr.curation.contents import Contents
from lfr.curation.verify import Report, verify_dataset
from lfr.data.opening import opened
from lfr.errors import DataError
from lfr.view.dataset import read_episode
from lfr.view.listing import dataset_entries

from . import arm, older
from .broken import cut, json_of, removed

EPISODES = 5
META = ("meta/episodes.jsonl", "meta/tasks.jsonl", "meta/episodes_stats.jsonl")


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two episodes to a folder. Do not write to it."""
    folder = tmp_path_factory.mktemp("older") / "arm-reach"
    return older.write(folder, arm.recording(EPISODES), size=2)


@pytest.fixture
def dataset(sound: Path, tmp_path: Path) -> Path:
    return shutil.copytree(sound, tmp_path / "arm-reach")


def verify(path: Path) -> Report:
    with opened(path, verify=True) as folder:
        return verify_dataset(folder)


@pytest.mark.parametrize("version", ["v2.1", "v2.0"])
def test_a_sound_dataset_has_no_finding(version: str, tmp_path: Path) -> None:
    recording = arm.recording(EPISODES)
    path = older.write(tmp_path / "arm", recording, version=version)
    before = {p: p.stat().st_mtime_ns for p in path.rglob("*")}
    report = verify(path)
    assert report.findings == ()
    assert report.path == path
    assert (report.episodes, report.frames) == (EPISODES, sum(map(len, recording.states)))
    assert {p: p.stat().st_mtime_ns for p in path.rglob("*")} == before


def test_it_holds_what_lerobots_own_converter_makes_of_it(dataset: Path, tmp_path: Path) -> None:
    from lerobot.datasets import LeRobotDataset
    from lerobot.scripts.convert_dataset_v21_to_v30 import convert_dataset

    theirs = shutil.copytree(dataset, tmp_path / "theirs")
    convert_dataset("local/theirs", root=theirs, push_to_hub=False)
    converted = Contents.open(theirs)
    with opened(dataset, verify=True) as path:
        ours = Contents.open(path)
        for key in ours.numeric():
            np.testing.assert_array_equal(ours.column(key), converted.column(key), err_msg=key)
        same = ("episode_index", "length", "dataset_from_index", "dataset_to_index", "tasks")
        for name in same:
            assert ours.episodes[name].to_pylist() == converted.episodes[name].to_pylist()
        statistics = [n for n in converted.episodes.column_names if n.startswith("stats/")]
        assert len(statistics) == 5 * 8
        for name in statistics:
            mine, other = (one.episodes[name].to_pylist() for one in (ours, converted))
            np.testing.assert_allclose(np.squeeze(mine), np.squeeze(other), err_msg=name)
        # LeRobot decodes the one long video that it made; ours are the episodes' own
        read = LeRobotDataset("local/theirs", root=theirs)
        start = int(ours.episodes["dataset_from_index"][3].as_py())
        shown = read[start + 7][arm.CAMERA].numpy().transpose(1, 2, 0)
        episode = read_episode(path, 3)
        (picture,) = _decoded(episode.images["top"][7:8])
        assert np.abs(picture / 255 - shown).mean() < 0.02


def _decoded(files: list[bytes]) -> list[np.ndarray]:
    import io

    from PIL import Image

    return [np.asarray(Image.open(io.BytesIO(file)), float) for file in files]


def test_it_is_viewed_by_its_own_name(sound: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recording = arm.recording(EPISODES)
    with opened(sound) as path:
        assert [one.length for one in dataset_entries(path)] == [len(s) for s in recording.states]
        for index in (0, 3):
            episode = read_episode(path, index)
            np.testing.assert_array_equal(episode.features[arm.STATE], recording.states[index])
            assert episode.metadata["instruction"] == older.TASKS[index % 2]
            assert episode.metadata["file"] == str(sound)
            assert len(episode.images["top"]) == len(recording.states[index])
    assert not path.exists()
    assert cli.main(["view", str(sound), "--list"]) == 0
    assert cli.main(["columns", str(sound)]) == 0
    printed = capsys.readouterr().out
    assert f"path: {sound}" in printed
    assert "convert_dataset_v21_to_v30" in printed
    assert cli.main(["view", str(sound), "--episode", "9", "--save", "x.rrd"]) == 2
    assert f"{sound}, episode 9, expected 0 to 4" in capsys.readouterr().err


def test_nothing_is_left_behind(
    sound: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    place = tmp_path / "temporary"
    place.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    assert cli.main(["verify", str(sound)]) == 0
    assert cli.main(["view", str(sound), "--episode", "9", "--save", "x.rrd"]) == 2
    assert not list(place.iterdir())


Damage = Callable[[Path], object]


def rows(episode: int, edit: Callable[[pa.Table], pa.Table]) -> Damage:
    def damage(path: Path) -> None:
        file = path / older.data(episode, 2)
        pq.write_table(edit(pq.read_table(file)), file)

    return damage


def of_column(name: str, edit: Callable[[list], object]) -> Callable[[pa.Table], pa.Table]:
    def change(table: pa.Table) -> pa.Table:
        values = table[name].to_pylist()
        edit(values)
        at = table.column_names.index(name)
        return table.set_column(at, name, pa.array(values, table.schema.field(name).type))

    return change


def lines(number: int, edit: Callable[[list[dict]], object]) -> Damage:
    return lambda path: older.change(path / META[number], edit)


def text(number: int, edit: Callable[[str], str]) -> Damage:
    def damage(path: Path) -> None:
        (path / META[number]).write_text(edit((path / META[number]).read_text()))

    return damage


def statistic(episode: int, key: str, name: str, value: list) -> Damage:
    return lines(2, lambda rows: rows[episode]["stats"][key].update({name: value}))


def info(**values: object) -> Damage:
    return json_of("meta/info.json", lambda content: content.update(values))


NAN = float("nan")
BROKEN: dict[str, tuple[Damage, str, str, str]] = {
    "NaN": (rows(2, of_column(arm.STATE, lambda v: v[5].__setitem__(1, NAN))), "not-finite",
            "error", r"chunk-001/episode_000002\.parquet, episode 2, column observation.state"),
    "a gap": (rows(1, of_column("timestamp", lambda v: v.__setitem__(
                  slice(9, None), [t + 1 for t in v[9:]]))),
              "gap-in-time", "error", r"chunk-000/episode_000001\.parquet, episode 1"),
    "rows missing": (removed(older.data(3, 2)), "missing-file", "error", older.data(3, 2)),
    "rows cut off": (cut(older.data(3, 2), 0.6), "damaged-file", "error", older.data(3, 2)),
    "a video missing": (removed(older.video(4, 2)), "missing-file", "error", older.video(4, 2)),
    "a video cut off": (cut(older.video(4, 2), 0.5), "damaged-file", "error", older.video(4, 2)),
    "another's video": (lambda d: shutil.copy(d / older.video(0, 2), d / older.video(1, 2)),
                        "video-frames", "", older.video(1, 2)),
    "a video too many": (lambda d: shutil.copy(d / older.video(0, 2), d / older.video(9)),
                         "left-over", "warning", "episode_000009"),
    "rows too many": (lambda d: shutil.copy(d / older.data(0, 2), d / "data/chunk-000/8.parquet"),
                      "left-over", "warning", "chunk-000/8"),
    "frames miscounted": (info(total_frames=7), "counts", "error", "total_frames, found 7"),
    "videos miscounted": (info(total_videos=7), "counts", "error", "found 7, expected 5"),
    "folders miscounted": (info(total_chunks=1), "counts", "error", "found 1, expected 3"),
    "another length": (lines(0, lambda r: r[1].update(length=3)), "counts", "error",
                       r"meta/episodes\.jsonl, episode 1, column length"),
    "an episode not listed": (lines(0, lambda r: r.pop(2)), "episode-index", "error",
                              r"meta/episodes\.jsonl"),
    "an episode twice": (lines(0, lambda r: r.append(r[1])), "episode-index", "error",
                         r"there twice: meta/episodes\.jsonl"),
    "no words": (lines(1, lambda r: r.pop()), "tasks", "error", "a task without words: data/"),
    "other words": (lines(0, lambda r: r[3].update(tasks=["Dance."])), "tasks", "error",
                    r"meta/episodes\.jsonl, episode 3, column tasks"),
    "a mean": (statistic(3, arm.ACTION, "mean", [9.0, 0.0, 0.0, 0.0]), "statistics", "error",
               r"meta/episodes_stats\.jsonl, episode 3, column stats/action/mean, found 9"),
    "a deviation": (statistic(3, arm.STATE, "std", [9.0, 9.0, 9.0, 9.0]), "statistics", "error",
                    r"meta/episodes_stats\.jsonl, episode 3, column stats/observation.state/std"),
    "a count": (statistic(3, arm.STATE, "count", [3]), "statistics", "error", "count, found 3"),
    "statistics of another size": (statistic(3, arm.STATE, "min", [0.0]), "schema", "error",
                                   r"episodes_stats\.jsonl, column stats/observation.state/min"),
    "pixels": (statistic(0, arm.CAMERA, "max", [[[255.0]], [[255.0]], [[255.0]]]), "statistics",
               "error", r"of \[0, 1\]: meta/episodes_stats\.jsonl, column observation.images.top"),
    "no statistics": (lines(2, lambda r: [row["stats"].pop(arm.ACTION) for row in r]), "statistics",
                      "warning", r"meta/episodes_stats\.jsonl, column action"),
    "an episode without": (lines(2, lambda r: r.pop(1)), "statistics", "error",
                           r"without statistics: meta/episodes_stats\.jsonl, found none of"),
    "statistics missing": (removed(META[2]), "missing-file", "warning", META[2]),
    "tasks missing": (removed(META[1]), "missing-file", "error", META[1]),
    "episodes missing": (removed(META[0]), "missing-file", "error", META[0]),
    "episodes cut off": (text(0, lambda t: t[:-9]), "damaged-file", "error",
                         r"meta/episodes\.jsonl, found line 5"),
    "tasks cut off": (text(1, lambda t: t[:-9]), "damaged-file", "error", r"tasks\.jsonl.*line 2"),
    "statistics cut off": (text(2, lambda t: t[:-9]), "damaged-file", "error", "found line 5"),
    "no object": (text(0, lambda t: t + "7\n[]\n"), "damaged-file", "error", r"line 6.*and 1 more"),
    "not text": (lambda d: (d / META[1]).write_bytes(b"\xff\xfe\x00"), "damaged-file", "error",
                 r"tasks\.jsonl, found line 1"),
    "no number": (lines(0, lambda r: r[2].update(length="many")), "schema", "error",
                  r"meta/episodes\.jsonl, found length: 'many' in line 3"),
    "no path": (info(data_path="{0.__class__}"), "info", "error", "data_path"),
    "another version": (info(codebase_version="v3.0"), "info", "error",
                        r"meta/info\.json, found v3\.0, expected v2\.1"),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_wrong_is_found_under_its_own_name(dataset: Path, name: str) -> None:
    damage, check, severity, shown = BROKEN[name]
    damage(dataset)
    report = verify(dataset)
    said = [str(finding) for finding in report.findings]
    assert any(
        finding.check == check and severity in finding.severity and re.search(shown, line)
        for finding, line in zip(report.findings, said, strict=True)
    ), "\n".join(said)
    assert not any(
        re.search(r"meta/episodes(/|\b(?!\.|_))|\.parquet.*tmp|lfr-", one) for one in said
    )
    assert json.dumps(report.as_json(), allow_nan=False)


def test_long_episodes_of_float32_are_as_precise_as_they_were(tmp_path: Path) -> None:
    """Statistics were added up one after the other in the values' own precision."""
    recording = arm.recording(1)
    states = np.full((30_000, 4), 0.1, np.float32)
    states[:, 0] += np.linspace(0, 1, len(states), dtype=np.float32)
    long = arm.Recording([states], [states + 0.3], recording.pictures)
    path = older.write(tmp_path / "long", long, pictures=False)
    assert not verify(path).errors
    older.change(path / META[2], lambda r: r[0]["stats"]["action"]["mean"].__setitem__(0, 0.91))
    assert [error.column for error in verify(path).errors] == ["stats/action/mean"]


@pytest.mark.parametrize("name", ["episodes cut off", "no number", "no path", "episodes missing"])
def test_readers_say_one_line(dataset: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    damage, *_, shown = BROKEN[name]
    damage(dataset)
    for command in (["view", "--list"], ["columns"]):
        assert cli.main([*command, str(dataset)]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert re.search(shown, line)
        assert str(dataset) in line


def test_v21_that_calls_itself_v30_is_read(dataset: Path) -> None:
    """What converts it wants it to say v2.1; lerobot 2652."""
    info(codebase_version="v3.0")(dataset)
    assert [str(f) for f in verify(dataset).findings] == [
        "error: info: files of another version than info.json says: meta/info.json, found v3.0, "
        "expected v2.1"
    ]
    assert cli.main(["view", str(dataset), "--list"]) == 0
    with pytest.raises(DataError, match=r"convert_dataset_v21_to_v30.*set it to v2\.1 first"):
        Contents.open(dataset)


def test_pictures_are_decoded_too(dataset: Path) -> None:
    black = np.zeros((len(arm.recording(EPISODES).states[2]), arm.SIZE, arm.SIZE, 3), np.uint8)
    arm.encode(dataset / older.video(2, 2), black)
    with opened(dataset, verify=True) as path:
        found = verify_dataset(path, pictures=2).findings
    assert ("blank-picture", 2) in {(one.check, one.episode) for one in found}


def test_whatever_stands_in_the_metadata_is_no_traceback(tmp_path: Path) -> None:
    """In place of every value of info.json and of a line of each other file."""
    wrongs = itertools.cycle([3, "x", [[1], [2, 3]], {}, None, True, 2**80, [None]])
    path = older.write(tmp_path / "arm", arm.recording(2), pictures=False)
    sound = json.loads((path / "meta/info.json").read_text())
    for key in sound:
        (path / "meta/info.json").write_text(json.dumps({**sound, key: next(wrongs)}))
        _survives(path)
    (path / "meta/info.json").write_text(json.dumps(sound))
    for file in META:
        whole = (path / file).read_text()
        for key in json.loads(whole.splitlines()[0]):
            for wrong in (next(wrongs), next(wrongs)):
                older.change(path / file, lambda rows, k=key, w=wrong: rows[1].update({k: w}))
                _survives(path)
                (path / file).write_text(whole)
    older.change(path / META[2], lambda rows: rows[1]["stats"].update({arm.STATE: next(wrongs)}))
    _survives(path)


def _survives(dataset: Path) -> None:
    for command in (["verify", "--json"], ["view", "--list"], ["columns"]):
        assert cli.main([*command, str(dataset)]) in (0, 1, 2)
    assert cli.main(["diff", str(dataset), str(dataset)]) in (0, 2)
