"""Datasets as they come: what other tools left out, cut off, linked or took away.

Whatever reads a dataset gives the right answer, or one line that names the place.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from lfr import cli
from lfr.curation import edit
from lfr.curation.contents import Contents
from lfr.curation.verify import verify_dataset
from lfr.data.features import dimension_names, names_of
from lfr.data.tables import DatasetFiles
from lfr.errors import DataError
from lfr.view.dataset import read_episode
from lfr.view.listing import dataset_entries

from . import arm
from .broken import cut, json_of, table

DATA = "data/chunk-000/file-000.parquet"
EPISODES = "meta/episodes/chunk-000/file-000.parquet"
VIDEO = f"videos/{arm.CAMERA}/chunk-000/file-000.mp4"


@pytest.fixture
def dataset(tmp_path: Path) -> Path:
    return arm.write(tmp_path / "arm", arm.recording(4), pictures=True)


def without(name: str) -> Callable[[Path], object]:
    return table(EPISODES, lambda t: t.drop_columns([name]))


def replaced(name: str, values: list, kind: pa.DataType) -> Callable[[Path], object]:
    def change(t: pa.Table) -> pa.Table:
        return t.set_column(t.column_names.index(name), name, pa.array(values, kind))

    return table(EPISODES, change)


UNPLACED = {
    "absent": (without, "no such column", 0),
    "null": (lambda c: replaced(c, [0, None, 0, 0], pa.int64()), "None", 1),
    "NaN": (lambda c: replaced(c, [0.0, float("nan"), 0.0, 0.0], pa.float64()), "nan", 1),
}


@pytest.mark.parametrize("how", UNPLACED)
def test_an_episode_whose_pictures_are_nowhere(dataset: Path, how: str, tmp_path: Path) -> None:
    column = f"videos/{arm.CAMERA}/chunk_index"
    damage, found, of = UNPLACED[how]
    damage(column)(dataset)
    report = verify_dataset(dataset)
    lines = [str(one) for one in report.findings if one.check == "placement"]
    assert any(column in line and found in line for line in lines)
    with pytest.raises(DataError, match=rf"episode 1, column {column}"):
        read_episode(dataset, 1)
    if of:  # known of the others, which can be kept
        edit.delete_episodes(dataset, [of], tmp_path / "rest")
        assert len(Contents.open(tmp_path / "rest").episodes) == 3
        assert len(read_episode(dataset, 0)) == Contents.open(dataset).lengths[0]
        cards = ["--to", str(tmp_path / "cards")]
        assert cli.main(["card", str(dataset), *cards]) == 0


@pytest.mark.parametrize("how", UNPLACED)
def test_rows_that_no_file_is_named_for_are_looked_for(
    dataset: Path, how: str, tmp_path: Path
) -> None:
    damage, *_ = UNPLACED[how]
    damage("data/chunk_index")(dataset)
    shutil.rmtree(dataset / "videos")
    json_of("meta/info.json", lambda info: info["features"].pop(arm.CAMERA))(dataset)
    expected = arm.recording(4).states[1]
    np.testing.assert_allclose(read_episode(dataset, 1).features[arm.STATE], expected, atol=1e-6)


def in_two_files(dataset: Path) -> None:
    """Episodes 2 and 3 into a file of their own, of which meta/episodes knows nothing."""
    rows = pq.read_table(dataset / DATA)
    at = int(Contents.open(dataset).lengths[:2].sum())
    pq.write_table(rows.slice(0, at), dataset / DATA)
    pq.write_table(rows.slice(at), dataset / DATA.replace("file-000", "file-001"))


def test_rows_in_another_file_than_is_said_are_found(dataset: Path) -> None:
    in_two_files(dataset)
    expected = arm.recording(4).states[2]
    np.testing.assert_allclose(read_episode(dataset, 2).features[arm.STATE], expected, atol=1e-6)
    assert "counts" in {one.check for one in verify_dataset(dataset).errors}


def test_what_was_not_downloaded_has_not_failed(dataset: Path) -> None:
    rows = pq.read_table(dataset / DATA)
    success = pa.array(np.ones(len(rows), bool))
    pq.write_table(rows.append_column("next.success", success), dataset / DATA)
    feature = {"dtype": "bool", "shape": [1], "names": None}
    json_of("meta/info.json", lambda i: i["features"].update({"next.success": feature}))(dataset)
    in_two_files(dataset)
    (dataset / DATA.replace("file-000", "file-001")).unlink()
    entries = dataset_entries(dataset)
    assert [entry.success for entry in entries] == [True, True, None, None]
    assert [bool(entry.note) for entry in entries] == [False, False, True, True]
    with pytest.raises(DataError, match=r"episode 2"):
        read_episode(dataset, 2)


def test_episodes_files_of_different_columns(dataset: Path) -> None:
    """A newer recorder went on: its own reader fails, ours say what is missing."""
    rows = pq.read_table(dataset / EPISODES)
    later = rows.slice(2).append_column("operator", pa.array(["ann", "ben"]))
    later = later.append_column("stats/action/q01", pa.array([[0.1] * 4] * 2))
    pq.write_table(rows.slice(0, 2), dataset / EPISODES)
    pq.write_table(later, dataset / EPISODES.replace("file-000", "file-001"))
    finding = next(one for one in verify_dataset(dataset).errors if "other files" in one.message)
    assert (finding.file, finding.column) == (EPISODES, "operator, stats/action/q01")
    assert finding.places == 2
    files = DatasetFiles.open(dataset)
    assert files.episode(0)["operator"] is None
    assert files.episode(3)["operator"] == "ben"
    assert len(dataset_entries(dataset)) == 4
    assert cli.main(["columns", str(dataset)]) == 0


def test_an_episode_that_was_taken_out_by_hand(dataset: Path, tmp_path: Path) -> None:
    """Episodes 0, 2 and 3 are left, under their numbers."""
    keep = pa.array([0, 2, 3])
    table(EPISODES, lambda t: t.take(keep))(dataset)
    table(DATA, lambda t: t.filter(pa.compute.field("episode_index") != 1))(dataset)  # pyright: ignore[reportAttributeAccessIssue]
    expected = arm.recording(4)
    for index in (0, 2, 3):
        found = read_episode(dataset, index).features[arm.STATE]
        np.testing.assert_allclose(found, expected.states[index], atol=1e-6)
    with pytest.raises(DataError, match=r"episode 1, expected 0 to 3"):
        read_episode(dataset, 1)
    edit.delete_episodes(dataset, [2], tmp_path / "two")
    for new, old in enumerate((0, 3)):
        found = read_episode(tmp_path / "two", new)
        np.testing.assert_allclose(found.features[arm.STATE], expected.states[old], atol=1e-6)
        assert len(found.images["top"]) == len(expected.states[old])


def test_folders_behind_links_are_followed(dataset: Path, tmp_path: Path) -> None:
    shutil.move(dataset / "data/chunk-000", tmp_path / "disk")
    (dataset / "data/chunk-000").symlink_to(tmp_path / "disk")
    (dataset / "data/chunk-001").symlink_to(dataset / "data")  # round and round
    report = verify_dataset(dataset)
    assert not report.errors, report.errors
    assert {"link"} <= {one.check for one in report.warnings}
    edit.delete_episodes(dataset, [1], tmp_path / "rest")
    assert len(read_episode(dataset, 2)) == Contents.open(dataset).lengths[2]


@pytest.mark.parametrize("kept", [0.0, 0.4])
def test_a_video_that_does_not_play_is_one_line(
    dataset: Path, kept: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cut(VIDEO, kept)(dataset)
    for command in (
        ["view", "--episode", "3", "--save", str(tmp_path / "x.rrd"), str(dataset)],
        ["card", str(dataset), "--to", str(tmp_path)],
    ):
        assert cli.main(command) == 2
        (line,) = [one for one in capsys.readouterr().err.splitlines() if "error" in one]
        assert VIDEO in line


def nested(file: str, depth: int) -> Callable[[Path], object]:
    def change(dataset: Path) -> None:
        text = (dataset / file).read_text() if (dataset / file).exists() else "{}"
        deep = "[" * depth + "]" * depth
        (dataset / file).write_text(f'{{"deep": {deep}, {text.strip()[1:]}'.replace(", }", "}"))

    return change


def template(name: str, value: str) -> Callable[[Path], object]:
    return json_of("meta/info.json", lambda info: info.update({name: value}))


def emptied(dataset: Path) -> None:
    for name in (DATA, EPISODES):
        table(name, lambda t: t.slice(0, 0))(dataset)


HOSTILE = {
    "nested": (nested("meta/info.json", 100_000), "info: .*info.json"),
    "nested a little": (nested("meta/info.json", 300), "info: .*info.json"),
    "nested statistics": (nested("meta/stats.json", 100_000), "statistics: .*stats.json"),
    "a width": (template("data_path", "data/{file_index:09999999999d}"), "info: .*data_path"),
    "an attribute": (template("video_path", "{video_key.__class__}.mp4"), "info: .*video_path"),
    "a rate of many digits": (template("fps", 10**400), "info: .*fps"),  # pyright: ignore[reportArgumentType]
    "no rows": (table(DATA, lambda t: t.slice(0, 0)), "counts: "),
    "nothing": (emptied, "counts: .*nothing in it"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_what_would_take_all_memory_or_all_of_the_stack(
    dataset: Path, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    damage, expected = HOSTILE[name]
    damage(dataset)
    lines = [str(one) for one in verify_dataset(dataset).errors]
    assert any(re.match(f"error: {expected}", line) for line in lines), lines
    for command in (
        ["view", "--list"], ["view", "--save", str(tmp_path / "x.rrd")], ["columns"],
        ["card", "--to", str(tmp_path / "cards")], ["publish", "--to", str(tmp_path / "out")],
    ):  # fmt: skip
        assert cli.main([*command, str(dataset)]) in (0, 2)
        assert len(capsys.readouterr().err.splitlines()) < 3


def test_v21_files_that_call_themselves_v30(dataset: Path) -> None:
    shutil.rmtree(dataset / "meta/episodes")
    (dataset / "meta/episodes.jsonl").write_text("{}\n")
    for read in (verify_dataset, DatasetFiles.open):
        with pytest.raises(DataError, match=r"convert_dataset_v21_to_v30.*of v2\.1"):
            read(dataset)


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["a", "b"], ["a", "b"]),
        ([["a", "b"]], ["a", "b"]),
        ({"motors": ["a", "b"]}, ["a", "b"]),
        ({"left": ["a"], "right": ["a"]}, ["left.a", "right.a"]),
        ({"b": 1, "a": 0}, ["a", "b"]),
        (None, []),
        ("state", []),
    ],
)
def test_names_are_read_in_one_way(names: object, expected: list[str]) -> None:
    feature = {"dtype": "float32", "shape": [2], "names": names}
    assert names_of(feature) == expected
    assert dimension_names(feature, "s") == (tuple(expected) if expected else ("s.0", "s.1"))


def test_one_name_for_a_whole_vector_is_a_warning(dataset: Path, tmp_path: Path) -> None:
    json_of("meta/info.json", lambda i: i["features"][arm.STATE].update(names=["state"]))(dataset)
    report = verify_dataset(dataset)
    assert not report.errors
    assert any("number of names" in one.message for one in report.warnings)
    edit.delete_episodes(dataset, [0], tmp_path / "rest")
