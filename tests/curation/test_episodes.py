"""A finding names all the episodes that it is about, not only the first of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from lfr.curation.contents import Contents, at_episodes
from lfr.curation.finding import Finding
from lfr.curation.verify import verify_dataset

from . import arm
from .broken import BROKEN, CAMERA, DATA, EPISODES, Break, column, info, stats
from .test_behaviour import half_rate

LENGTHS = (12, 9, 15, 7, 12)  # of the fixture's episodes


def rows(name: str, *numbers: int, value: object) -> Break:
    def edit(values: list) -> None:
        for number in numbers:
            values[number] = value

    return column(DATA, name, edit)


def episodes(name: str, *numbers: int, value: object) -> Break:
    def edit(values: list) -> None:
        for number in numbers:
            values[number] = value

    return column(EPISODES, name, edit)


def dimensions(name: str, *numbers: int, value: float) -> Break:
    def edit(values: list) -> None:
        for number in numbers:
            values[number][1] = value

    return column(DATA, name, edit)


def still(*numbers: int) -> Break:
    starts = np.cumsum((0, *LENGTHS))

    def broken(dataset: Path) -> None:
        for key in ("state", "environment_state", "joint_position"):

            def edit(values: list) -> None:
                for number in numbers:
                    begin, end = starts[number], starts[number + 1]
                    values[begin:end] = [values[begin]] * (end - begin)

            column(DATA, f"observation.{key}", edit)(dataset)

    return broken


FROM, TO = (f"videos/{CAMERA}/{end}_timestamp" for end in ("from", "to"))

# Row 14 lies in episode 1, row 25 and 33 in episode 2, row 50 in episode 4.
SEVERAL: dict[str, tuple[Break, str, tuple[int, ...]]] = {
    "NaN": (dimensions("action", 14, 50, value=float("nan")), "not-finite", (1, 4)),
    "twice in one": (dimensions("action", 25, 33, value=float("nan")), "not-finite", (2,)),
    "out of range": (dimensions("action", 14, 25, 50, value=1.5), "range", (1, 2, 4)),
    "time": (rows("timestamp", 14, 33, value=0.0), "jump-in-time", (1, 2)),
    "tasks of rows": (rows("task_index", 14, 50, value=4), "tasks", (1, 4)),
    "tasks of episodes": (episodes("tasks", 1, 3, value=["Dance."]), "tasks", (1, 3)),
    "words": (column("meta/tasks.parquet", "task", lambda v: v.__setitem__(0, " ")), "tasks",
              (0, 1, 2, 3, 4)),
    "lengths": (episodes("length", 1, 3, value=10), "counts", (1, 3)),
    "empty episodes": (episodes("length", 1, 3, value=0), "counts", (1, 3)),
    "outcomes": (episodes("success", 2, 4, value=False), "success", (2, 4)),
    "frozen": (still(1, 3), "frozen", (1, 3)),
    "placement": (episodes("data/file_index", 2, 3, value=None), "placement", (2, 3)),
    "a file gone": (episodes("data/file_index", 2, 3, value=1), "missing-file", (2, 3)),
    "a video gone": (episodes(f"videos/{CAMERA}/file_index", 0, 3, value=1), "missing-file",
                     (0, 3)),
    "statistics": (column(EPISODES, "stats/action/mean", lambda v: [
        v[i].__setitem__(0, 0.9) for i in (0, 3)]), "statistics", (0, 3)),
    "between frames": (lambda d: [episodes(FROM, 2, value=1.06)(d),
                                  episodes(FROM, 3, value=1.81)(d)], "video-frames", (2, 3)),
    "done": (rows("next.done", 4, 25, value=True), "done", (0, 2)),
    "a video too short": (BROKEN["a shorter video"][0], "video-frames", (1, 2, 3, 4)),
    "a video cut off": (BROKEN["video cut off"][0], "damaged-file", (0, 1, 2, 3, 4)),
    "rows cut off": (BROKEN["rows cut off"][0], "damaged-file", (0, 1, 2, 3, 4)),
    "another dtype": (BROKEN["another dtype"][0], "dtype", (0, 1, 2, 3, 4)),
    # of the dataset as a whole
    "frames miscounted": (info(total_frames=50), "counts", ()),
    "a mean": (stats(lambda s: s["action"]["mean"].__setitem__(3, 0.9)), "statistics", ()),
    "constant": (BROKEN["constant"][0], "constant", ()),
}  # fmt: skip


@pytest.mark.parametrize("name", SEVERAL)
def test_every_episode_is_named(dataset: Path, name: str) -> None:
    damage, check, expected = SEVERAL[name]
    damage(dataset)
    found = [f for f in verify_dataset(dataset).findings if f.check == check]
    assert expected in [f.episodes for f in found], [(str(f), f.episodes) for f in found]


def test_of_several_files_a_damaged_one_names_its_own(dataset: Path) -> None:
    table = pq.read_table(dataset / DATA)
    second = dataset / DATA.replace("file-000", "file-001")
    pq.write_table(table.slice(0, 36), dataset / DATA)
    pq.write_table(table.slice(36), second)
    episodes("data/file_index", 3, 4, value=1)(dataset)
    assert verify_dataset(dataset).findings == ()
    second.write_bytes(second.read_bytes()[:-20])
    (finding,) = verify_dataset(dataset).findings
    assert (finding.check, finding.episodes) == ("damaged-file", (3, 4))
    pq.write_table(table.slice(36).drop_columns(["action"]), second)
    assert {f.episodes for f in verify_dataset(dataset).findings} == {(3, 4)}


def test_undecodable_pictures_name_the_episodes_behind_the_damage(tmp_path: Path) -> None:
    of = arm.recording(4)
    path = arm.write(tmp_path / "arm", of, pictures=True)
    shown = np.concatenate(of.pictures)[: len(of.pictures[0]) + len(of.pictures[1]) + 5]
    arm.encode(path / f"videos/{arm.CAMERA}/chunk-000/file-000.mp4", shown)
    found = [f for f in verify_dataset(path, pictures=2).findings if f.check == "damaged-picture"]
    assert [f.episodes for f in found] == [(2, 3)]


def test_a_rate_that_all_have_names_all(tmp_path: Path) -> None:
    of = arm.recording(6)
    half_rate(of)
    path = arm.write(tmp_path / "arm", of)
    (found,) = [f for f in verify_dataset(path).findings if f.check == "repeated-rows"]
    assert found.episodes == tuple(range(6))


def test_the_episode_alone_is_all_of_them() -> None:
    finding = Finding("jump", "jumps", episode=3)
    assert finding.episodes == (3,)
    assert replace(finding, episodes=(3, 5)).as_json()["episodes"] == [3, 5]
    assert str(replace(finding, episodes=(3, 5))) == str(finding)
    assert Finding("constant", "the same").episodes == ()


def test_rows_and_episodes_by_mask_or_number(tmp_path: Path) -> None:
    of = arm.recording(3)
    contents = Contents.open(arm.write(tmp_path / "arm", of))
    ends = np.cumsum([len(state) for state in of.states])
    wrong = np.zeros(ends[-1], bool)
    wrong[[ends[0] - 1, ends[0], ends[1] + 4]] = True
    for which in (wrong, np.flatnonzero(wrong)):
        at, where = contents.at_rows(which)
        assert at == where["row"] == ends[0] - 1
        assert (where["episode"], where["episodes"], where["places"]) == (0, (0, 1, 2), 3)
    for which in (np.array([False, True, True]), np.array([1, 2])):
        assert at_episodes(which) == (1, {"episode": 1, "places": 2, "episodes": (1, 2)})


def test_rows_without_an_episode_have_a_place_all_the_same(tmp_path: Path) -> None:
    path = arm.write(tmp_path / "arm", arm.recording(2))
    file = path / DATA
    table = pq.read_table(file)
    pq.write_table(table.drop_columns(["episode_index"]), file)
    at, where = Contents.open(path).at_rows(np.array([4, 5]))
    assert (at, where["episode"], where["places"]) == (4, None, 2)
    assert "episodes" not in where
