"""What changed between two datasets is said, and nothing else; what leaks is found."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from lfr import cli
from lfr.curation import edit
from lfr.curation.contents import Contents
from lfr.curation.diff.comparison import Comparison, compare_datasets
from lfr.curation.diff.difference import Difference, listed
from lfr.curation.diff.side import Side
from lfr.curation.diff.statistics import moments
from lfr.data import tables
from lfr.errors import DataError

from . import arm, made_up
from .broken import DATA, EPISODES, TASKS, VIDEO, column, cut, feature, info, put, removed, table
from .broken import dimension as dimension_of

CAMERA = "observation.images.agentview"
OURS = ["seed", "success", "robot", "task_name", "log_file", "log_sha256"]


def of_kind(found: Comparison, kind: str) -> list[tuple[int | None, int | None]]:
    """The episodes of all findings of a kind, in A and in B."""
    return [pair for one in found.differences if one.kind == kind for pair in one.episodes]


def kinds(found: Comparison) -> set[str]:
    return {one.kind for one in found.differences}


def the(found: Comparison, kind: str) -> Difference:
    """The only one of a kind."""
    (one,) = (one for one in found.differences if one.kind == kind)
    return one


@pytest.fixture
def copy(sound: Path, tmp_path: Path) -> Path:
    """Of the sound dataset, to be changed; without its logs."""
    return shutil.copytree(sound, tmp_path / "copy")


# Nothing differs


def test_a_dataset_and_itself(sound: Path, by_lerobot: Path, tmp_path: Path) -> None:
    every_kind = made_up.record_every_kind(tmp_path / "kinds")
    for path, episodes in ((sound, 5), (by_lerobot, 3), (every_kind, 4)):
        found = compare_datasets(path, path)
        assert (found.differences, found.not_compared) == ((), ())
        assert (found.same, found.episodes) == (episodes, (episodes, episodes))
        assert str(found).endswith(f"{episodes} the same; nothing differs")
        assert cli.main(["diff", str(path), str(path)]) == 0


def test_how_the_same_values_are_stored_is_no_difference(by_lerobot: Path, tmp_path: Path) -> None:
    """Other files, row groups, kinds of lists, wider numbers, another sign of 0, another NaN."""
    paths = [shutil.copytree(by_lerobot, tmp_path / name) for name in "ab"]
    rows = pq.read_table(by_lerobot / DATA)
    rows = rows.replace_schema_metadata()
    state = np.array(rows["observation.state"].to_pylist(), np.float32)
    state[3], state[4, 0] = 0.0, np.nan
    other = state.copy()
    other[3] *= -1.0
    other[4, 0] = np.array([0xFFC00001], np.uint32).view(np.float32)[0]
    at = rows.column_names.index("observation.state")
    for path, values, kind in ((paths[0], state, pa.list_(pa.float32(), 3)),
                               (paths[1], other, pa.large_list(pa.float64()))):  # fmt: skip
        written = rows.set_column(at, "observation.state", pa.array(list(values), kind))
        for number, part in enumerate((written.slice(0, 30), written.slice(30))):
            file = path / DATA.replace("file-000", f"file-{number:03d}")
            size = 1000 if path == paths[0] else 7
            pq.write_table(part if path == paths[1] else written, file, row_group_size=size)
            if path == paths[0]:
                break
    found = compare_datasets(*paths)
    assert found.differences == ()


def test_another_numbering_of_tasks_is_no_difference(by_lerobot: Path, tmp_path: Path) -> None:
    other = shutil.copytree(by_lerobot, tmp_path / "other")
    column(DATA, "task_index", lambda v: v.__setitem__(slice(None), [1 - i for i in v]))(other)
    column(TASKS, "task_index", lambda v: v.__setitem__(slice(None), [1 - i for i in v]))(other)
    assert compare_datasets(by_lerobot, other).differences == ()


# Editing


def test_what_is_deleted_is_dropped_and_the_rest_moved(sound: Path, tmp_path: Path) -> None:
    edit.delete_episodes(sound, [1, 3], tmp_path / "out")
    found = compare_datasets(sound, tmp_path / "out")
    assert of_kind(found, "dropped") == [(1, None), (3, None)]
    assert of_kind(found, "moved") == [(2, 1), (4, 2)]
    # 12, 9, 15, 7, 12 frames, every second a key frame: episode 0 alone could be cut
    assert of_kind(found, "encoded-anew") == [(2, 1), (4, 2)]
    assert kinds(found) == {"dropped", "moved", "encoded-anew", "statistics"}
    assert found.same == 1
    lines = [str(line) for line in found.lines]
    assert lines[0] == "dropped: not in B: episodes 1, 3"
    assert lines[1] == "moved: another episode_index: episodes 2 (1 in B), 4 (2 in B)"
    back = compare_datasets(tmp_path / "out", sound)
    assert of_kind(back, "added") == [(None, 1), (None, 3)]


def test_what_is_split_and_merged_again_differs_in_its_order(sound: Path, tmp_path: Path) -> None:
    edit.split_episodes(sound, {"a": [0, 1], "b": [2, 3, 4]}, tmp_path / "parts")
    a, b = tmp_path / "parts/a", tmp_path / "parts/b"
    edit.merge_datasets([b, a], tmp_path / "turned")
    edit.merge_datasets([a, b], tmp_path / "again")
    found = compare_datasets(sound, tmp_path / "again")
    assert {pair for one in found.differences for pair in one.episodes} == {(2, 2), (3, 3), (4, 4)}
    assert kinds(found) == {"encoded-anew"}  # they began between two key frames
    found = compare_datasets(sound, tmp_path / "turned")
    assert of_kind(found, "moved") == [(0, 3), (1, 4), (2, 0), (3, 1), (4, 2)]
    assert kinds(found) == {"moved", "encoded-anew"}


def test_what_lerobot_deletes_and_drops(sound: Path, tmp_path: Path) -> None:
    from lerobot.datasets import LeRobotDataset
    from lerobot.datasets.dataset_tools import delete_episodes, merge_datasets

    whole = LeRobotDataset("lfr/whole", root=sound)
    rest = delete_episodes(whole, [2], output_dir=tmp_path / "rest", repo_id="lfr/rest")
    found = compare_datasets(sound, tmp_path / "rest")
    assert of_kind(found, "dropped") == [(2, None)]
    assert of_kind(found, "moved") == [(3, 2), (4, 3)]
    assert [one.column for one in found.differences if one.kind == "episode-column"] == OURS
    assert not kinds(found) & {"changed", "words", "pictures", "added", "length", "meta"}
    merge_datasets([rest, whole], output_repo_id="lfr/both", output_dir=tmp_path / "both")
    found = compare_datasets(tmp_path / "rest", tmp_path / "both")
    assert of_kind(found, "added") == [(None, 4), (None, 5), (None, 6), (None, 7), (None, 8)]
    assert not kinds(found) & {"changed", "words", "pictures", "moved", "dropped"}


def test_an_episode_there_twice_is_added_once(sound: Path, tmp_path: Path) -> None:
    """Also where all that is asked is which of equals was there."""
    edit.delete_episodes(sound, [0, 1, 2], tmp_path / "some")
    table(EPISODES, lambda t: t.drop_columns(OURS))(tmp_path / "some")  # else it would be refused
    edit.merge_datasets([sound, tmp_path / "some"], tmp_path / "twice")
    found = compare_datasets(sound, tmp_path / "twice")
    assert of_kind(found, "added") == [(None, 5), (None, 6)]
    assert not of_kind(found, "moved")


# Changes


def test_a_value_that_changed(sound: Path, copy: Path) -> None:
    before = pq.read_table(sound / DATA)["action"].to_pylist()[14][2]
    dimension_of("action", 14, 2, before + 0.25)(copy)
    found = compare_datasets(sound, copy)
    one = the(found, "changed")
    name = Contents.open(sound).features["action"]["names"][2]
    assert (one.episodes, one.column, one.rows) == (((1, 1),), f"action: {name}", 1)
    assert one.largest == pytest.approx(0.25, abs=1e-6)
    assert (found.same, kinds(found)) == (4, {"changed"})


def test_a_change_and_a_move_are_told_apart(sound: Path, tmp_path: Path) -> None:
    """Deleted and changed: the changed one is none of those that have its number."""
    edit.delete_episodes(sound, [1], tmp_path / "out")
    put(DATA, "next.reward", 12 + 15 + 2, 0.125)(tmp_path / "out")  # of 3, which is 2 now
    column(EPISODES, "seed", lambda v: v.__setitem__(slice(None), [7, 7, 7, 7]))(tmp_path / "out")
    found = compare_datasets(sound, tmp_path / "out")
    assert of_kind(found, "dropped") == [(1, None)]
    assert of_kind(found, "moved") == [(2, 1), (3, 2), (4, 3)]
    assert of_kind(found, "changed") == [(3, 2)]
    assert of_kind(found, "meta") == [(0, 0), (2, 1), (3, 2), (4, 3)]


def test_episodes_of_which_all_is_changed_are_found_by_their_seed(sound: Path, copy: Path) -> None:
    def scale(values: list[Any]) -> None:
        values[:] = [[-3.0 * x + 1 for x in row] for row in values]

    keys = [k for k in Contents.open(sound).numeric() if k == "action" or k.startswith("obs")]
    for key in keys:
        column(DATA, key, scale)(copy)
    column(EPISODES, "success", lambda v: v.__setitem__(0, False))(copy)
    found = compare_datasets(sound, copy)
    assert not kinds(found) & {"dropped", "added", "moved"}
    changed = {one.column for one in found.differences if one.kind == "changed"}
    assert changed == set(keys)
    assert the(found, "meta").column == "success"


def test_two_recordings_have_nothing_in_common(tmp_path: Path) -> None:
    """Though some of their episodes have the same number and length."""
    a, b = (
        arm.write(tmp_path / str(seed), arm.recording(40, seed, drawn=False)) for seed in (1, 2)
    )
    lengths = [Contents.open(each).lengths for each in (a, b)]
    assert (lengths[0] == lengths[1]).any()
    found = compare_datasets(a, b)
    assert len(of_kind(found, "dropped")) == len(of_kind(found, "added")) == 40
    assert kinds(found) <= {"dropped", "added", "statistics"}


def test_half_of_the_rows_are_enough_to_know_an_episode(tmp_path: Path) -> None:
    """Without a seed, under another number, the other half far from what it was."""
    recorded = arm.recording(6, drawn=False)
    a = arm.write(tmp_path / "a", recorded)
    for episodes in (recorded.states, recorded.actions):
        changed = episodes.pop(1)
        changed[::3] += 1.0
        changed[1::9] += 1.0
        episodes.append(changed)
    found = compare_datasets(a, arm.write(tmp_path / "b", recorded))
    assert set(of_kind(found, "changed")) == {(1, 5)}
    assert (1, 5) in of_kind(found, "moved")
    assert not kinds(found) & {"dropped", "added", "length"}


def test_an_episode_that_was_cut(tmp_path: Path) -> None:
    whole = arm.recording(6, drawn=False)
    a = arm.write(tmp_path / "a", whole)
    for episodes in (whole.states, whole.actions):
        episodes[2] = episodes[2][5:-3]
        episodes[4] = np.concatenate([episodes[4][:1] + 1, episodes[4]])
    found = compare_datasets(a, arm.write(tmp_path / "b", whole))
    cut, longer = (one for one in found.differences if one.kind == "length")
    assert (cut.episodes, longer.episodes) == (((2, 2),), ((4, 4),))
    assert cut.b.endswith("from A's row 5 on")
    assert longer.b.endswith("1 of them before A's first")
    assert not of_kind(found, "changed")
    assert found.same == 4


def test_episodes_with_noise_and_shifted_are_found(tmp_path: Path) -> None:
    whole, random = arm.recording(6, drawn=False), np.random.default_rng(3)
    a = arm.write(tmp_path / "a", whole)
    for episodes in (whole.states, whole.actions):
        episodes[:] = [e + random.normal(0, 2e-4, e.shape).astype(np.float32) for e in episodes]
        episodes[2] = episodes[2][7:]
    found = compare_datasets(a, arm.write(tmp_path / "b", whole))
    assert {pair for pair in of_kind(found, "changed")} == {(i, i) for i in range(6)}
    assert the(found, "length").b.endswith("from A's row 7 on")
    assert max(one.largest or 0 for one in found.differences) < 0.02
    assert not kinds(found) & {"dropped", "added", "moved"}


def test_other_times_other_words_and_other_entries(sound: Path, copy: Path) -> None:
    column(DATA, "timestamp", lambda v: v.__setitem__(slice(0, 12), [t * 2 for t in v[:12]]))(copy)
    column(TASKS, "task", lambda v: v.__setitem__(0, "Drop it."))(copy)
    put(EPISODES, "success", 3, False)(copy)
    found = compare_datasets(sound, copy)
    one = the(found, "changed")
    assert (one.column, one.episodes, one.rows) == ("timestamp", ((0, 0),), 11)
    words = [one for one in found.differences if one.kind == "words"]
    assert [w.episodes for w in words] == [((i, i),) for i in range(5)]
    assert {(w.a, w.b) for w in words} == {("Lift the cube.", "Drop it.")}
    meta = the(found, "meta")
    assert (meta.column, meta.episodes, meta.a, meta.b) == ("success", ((3, 3),), True, False)
    joined = [line for line in found.lines if line.kind == "words"]
    assert str(joined[0]).startswith("words: another task: episodes 0-4, A Lift the cube., B Drop")


# Pictures


def test_pictures_encoded_anew_and_other_pictures(tmp_path: Path) -> None:
    recorded = arm.recording(4)
    a = arm.write(tmp_path / "a", recorded, pictures=True)
    b = shutil.copytree(a, tmp_path / "b")
    video = f"videos/{arm.CAMERA}/chunk-000/file-000.mp4"
    arm.encode(b / video, np.concatenate(recorded.pictures), "libsvtav1")
    found = compare_datasets(a, b)
    assert of_kind(found, "encoded-anew") == [(i, i) for i in range(4)]
    assert kinds(found) == {"encoded-anew"}
    assert (found.differences[0].a, found.differences[0].b) == ("h264 64x64", "av1 64x64")
    recorded.pictures[2] = recorded.pictures[2][:, ::-1].copy()
    arm.encode(b / video, np.concatenate(recorded.pictures), "libsvtav1")
    found = compare_datasets(a, b)
    assert of_kind(found, "pictures") == [(2, 2)]
    assert of_kind(found, "encoded-anew") == [(0, 0), (1, 1), (3, 3)]
    assert the(found, "pictures").largest == pytest.approx(0.5, abs=0.3)
    left = compare_datasets(a, b, pictures=0)
    assert (left.differences, left.not_compared) == ((), ("pictures",))


def test_pictures_a_little_darker_all_along_are_others(tmp_path: Path) -> None:
    recorded = arm.recording(3)
    a = arm.write(tmp_path / "a", recorded, pictures=True)
    recorded.pictures[1] = (recorded.pictures[1] * 0.85).astype(np.uint8)
    found = compare_datasets(a, arm.write(tmp_path / "b", recorded, pictures=True))
    assert of_kind(found, "pictures") == [(1, 1)]
    assert (the(found, "pictures").largest or 1) < 0.2


def test_pictures_some_rows_late_are_others(tmp_path: Path) -> None:
    recorded = arm.recording(3)
    a = arm.write(tmp_path / "a", recorded, pictures=True)
    recorded.pictures[1] = np.roll(recorded.pictures[1], 5, axis=0)
    found = compare_datasets(a, arm.write(tmp_path / "b", recorded, pictures=True), pictures=1)
    assert of_kind(found, "pictures") == [(1, 1)]


def test_a_video_that_cannot_be_read_is_a_difference(sound: Path, copy: Path) -> None:
    for damage, message in ((removed(VIDEO), "not there, in B"), (cut(VIDEO, 0), "cannot be read")):
        shutil.copy(sound / VIDEO, copy / VIDEO)
        damage(copy)
        found = compare_datasets(sound, copy)
        assert kinds(found) == {"unreadable"}
        assert message in the(found, "unreadable").message
        assert cli.main(["diff", str(sound), str(copy)]) == 1
    (copy / VIDEO).write_bytes(b"no video " * 100)
    assert kinds(compare_datasets(sound, copy)) == {"unreadable"}


# Features


@pytest.mark.parametrize(
    ("change", "kind", "column", "values"),
    [
        (info(fps=30), "info", "fps", (20, 30)),
        (info(robot_type="other"), "info", "robot_type", ("panda", "other")),
        (info(splits={"train": "0:3", "val": "3:5"}), "info", "splits", None),
        (feature("action", dtype="float64"), "feature", "action", ("float32", "float64")),
        (feature("action", shape=[8]), "feature", "action", ([7], [8])),
        (feature("action", names=list("abcdefg")), "feature", "action", None),
        (feature(CAMERA, shape=[32, 64, 3]), "feature", CAMERA, None),
        (feature(CAMERA, info={"video.codec": "h264"}), "video", f"{CAMERA}: video.codec",
         ("av1", "h264")),
        (lambda d: table(DATA, lambda t: t.drop_columns(["action"]))(d)
         or _without(d, "action"), "feature", "action", (None, None)),
        (table(EPISODES, lambda t: t.drop_columns(["seed"])), "episode-column", "seed", None),
        (table(EPISODES, lambda t: t.drop_columns(
            [n for n in t.column_names if n.startswith("stats/action/")])), "episode-column",
         "stats/action", None),
        (table(EPISODES, lambda t: t.append_column("operator", pa.array(["ann"] * 5))),
         "episode-column", "operator", None),
    ],
)  # fmt: skip
def test_what_a_dataset_says_of_itself(
    sound: Path, copy: Path, change: Callable[[Path], object], kind: str, column: str, values: Any
) -> None:
    change(copy)
    found = compare_datasets(sound, copy, pictures=0)
    one = the(found, kind)
    assert one.column == column
    assert values is None or (one.a, one.b) == values
    assert kinds(found) == {kind}  # so the episodes are the same by what both have
    assert len(compare_datasets(copy, sound, pictures=0).differences) == 1


def _without(dataset: Path, key: str) -> None:
    content = json.loads((dataset / "meta/info.json").read_text())
    del content["features"][key]
    (dataset / "meta/info.json").write_text(json.dumps(content))
    stats = [n for n in pq.read_schema(dataset / EPISODES).names if n.startswith(f"stats/{key}/")]
    table(EPISODES, lambda t: t.drop_columns(stats))(dataset)


def test_dimensions_in_another_order_are_the_same(tmp_path: Path) -> None:
    recorded = arm.recording(4, drawn=False)
    a = arm.write(tmp_path / "a", recorded)
    recorded.states = [state[:, [2, 0, 1, 3]] for state in recorded.states]
    b = arm.write(tmp_path / "b", recorded)
    feature(arm.STATE, names=[arm.NAMES[i] for i in (2, 0, 1, 3)])(b)
    found = compare_datasets(a, b)
    assert "another order" in the(found, "feature").message
    assert found.same == 4
    feature(arm.STATE, names=arm.NAMES)(b)  # but values that are others'
    found = compare_datasets(a, b)
    assert set(of_kind(found, "changed")) == {(i, i) for i in range(4)}
    assert found.differences[0].column == f"{arm.STATE}: {', '.join(arm.NAMES[:3])}"


def test_a_dimension_more_leaves_the_others_comparable(tmp_path: Path) -> None:
    recorded = arm.recording(3, drawn=False)
    a = arm.write(tmp_path / "a", recorded)
    for i, state in enumerate(recorded.states):
        recorded.states[i] = np.concatenate([state[:, :1], state], axis=1)
    b = arm.write(tmp_path / "b", recorded)
    feature(arm.STATE, names=["more", *arm.NAMES], shape=[5])(b)
    found = compare_datasets(a, b)
    assert (kinds(found), found.same, found.not_compared) == ({"feature"}, 3, ())
    feature(arm.STATE, names=None)(b)
    assert compare_datasets(a, b).not_compared == (f"{arm.STATE} (other shapes)",)


# Statistics


def test_what_moved_furthest_comes_first(tmp_path: Path) -> None:
    recorded = arm.recording(8, drawn=False)
    a = arm.write(tmp_path / "a", recorded)
    before = np.concatenate(recorded.states).astype(np.float64)
    for state in recorded.states:
        state[:, 1] += np.float32(2 * before[:, 1].std())
        state[:, 2] *= 1.5
    found = compare_datasets(a, arm.write(tmp_path / "b", recorded), lines=1)
    moved = [one for one in found.differences if one.kind == "statistics"]
    assert [one.column for one in moved] == [f"{arm.STATE}: {arm.NAMES[i]}" for i in (1, 2)]
    assert "by 2 standard deviations" in moved[0].message
    assert moved[0].a == f"{before[:, 1].mean():.4g} ± {before[:, 1].std():.4g}"
    told = re.search(r"by ([\d.]+) standard", moved[1].message)
    mean, std = before[:, 2].mean(), before[:, 2].std()
    assert told
    assert float(told[1]) == pytest.approx(max(0.5, abs(0.5 * mean) / std), rel=1e-2)
    lines = [str(line) for line in found.lines if line.kind == "statistics"]
    assert len(lines) == 2
    assert "1 more dimensions" in lines[1]


@pytest.mark.parametrize(("factor", "said"), [(180 / np.pi, "degrees"), (1e-3, "millimetres")])
def test_other_units_are_told_from_the_values(tmp_path: Path, factor: float, said: str) -> None:
    recorded = arm.recording(8, drawn=False)
    a = arm.write(tmp_path / "a", recorded)
    for state in recorded.states:
        state[:, :3] *= factor
    found = compare_datasets(a, arm.write(tmp_path / "b", recorded))
    unit = the(found, "unit")
    assert unit.column == f"{arm.STATE}: {', '.join(arm.NAMES[:3])}"
    assert said in unit.message
    assert unit.message.endswith("in A?" if factor > 1 else "in B?")
    assert "statistics" not in kinds(found)
    assert set(of_kind(found, "changed")) == {(i, i) for i in range(8)}


def test_of_other_episodes_of_the_same_task_no_unit_is_doubted(tmp_path: Path) -> None:
    a, b = (
        arm.write(tmp_path / str(seed), arm.recording(20, seed, drawn=False)) for seed in (5, 6)
    )
    assert "unit" not in kinds(compare_datasets(a, b))


def test_moments_over_many_batches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lfr.curation.diff.side.BATCH", 7)
    recorded = arm.recording(2, drawn=False)
    recorded.states[0][:9, 1] = np.nan
    side = Side.open(arm.write(tmp_path / "a", recorded))
    found, values = moments(side, arm.STATE, (1, 3)), np.concatenate(recorded.states)[:, [1, 3]]
    values = values.astype(np.float64)
    assert found.count.tolist() == [len(values) - 9, len(values)]
    np.testing.assert_allclose(found.mean, np.nanmean(values, axis=0), rtol=1e-12)
    np.testing.assert_allclose(found.std, np.nanstd(values, axis=0), rtol=1e-12)


# What anybody may have written


def no_text(dataset: Path) -> None:
    """The name of a column, in bytes that are no UTF-8."""
    content = (dataset / EPISODES).read_bytes()
    (dataset / EPISODES).write_bytes(content.replace(b"seed", b"\xa4eed"))


def test_what_is_no_dataset_is_one_line(
    sound: Path, copy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for damage in (cut(DATA, 0.6), cut(EPISODES, 0.5), cut("meta/info.json", 0.5), removed(TASKS),
                   no_text, put(EPISODES, "length", 1, 10), put(EPISODES, "episode_index", 1, 0),
                   table(EPISODES, lambda t: t.drop_columns(["length"])),
                   table(DATA, lambda t: t.drop_columns(["task_index"]))):  # fmt: skip
        shutil.rmtree(copy)
        shutil.copytree(sound, copy)
        damage(copy)
        for pair in ((sound, copy), (copy, sound)):
            assert cli.main(["diff", *map(str, pair)]) == 2
            (line,) = capsys.readouterr().err.splitlines()
            assert line.startswith("lfr: error: ")
            assert str(copy) in line
    assert cli.main(["diff", str(sound), str(tmp_path / "nowhere")]) == 2


def test_no_episodes(sound: Path, by_lerobot: Path, copy: Path) -> None:
    """Neither a table without rows nor a file without them is in the way."""
    for file in (EPISODES, DATA):
        table(file, lambda t: t.slice(0, 0))(copy)
    info(splits={})(copy)
    found = compare_datasets(copy, sound)
    assert of_kind(found, "added") == [(None, i) for i in range(5)]
    assert kinds(found) == {"added"}
    assert compare_datasets(copy, copy).differences == ()


def test_missing_and_infinite_numbers_are_compared(sound: Path, copy: Path) -> None:
    dimension_of("observation.state", 14, 2, float("nan"))(copy)
    dimension_of("observation.state", 15, 3, float("inf"))(copy)
    put(DATA, "next.reward", 3, None)(copy)
    found = compare_datasets(sound, copy)
    changed = {one.column: one for one in found.differences if one.kind == "changed"}
    assert [one.rows for one in changed.values()] == [2, 1]
    assert changed["next.reward"].largest is None
    assert json.loads(json.dumps(found.as_json(), allow_nan=False))
    assert compare_datasets(copy, copy).differences == ()


def test_a_column_with_gaps_is_compared_row_by_row(sound: Path, copy: Path) -> None:
    """Where a whole vector is missing there are no numbers; the other rows are as they were."""
    put(DATA, "action", 14, None)(copy)
    rows = pq.read_table(copy / DATA)
    assert rows["action"].null_count == 1
    found = compare_datasets(sound, copy)
    one = the(found, "changed")
    assert (one.column, one.episodes, one.rows, one.largest) == ("action", ((1, 1),), 1, None)
    assert compare_datasets(copy, copy).differences == ()


def test_large_whole_numbers_differ_by_one(tmp_path: Path) -> None:
    """2^53 + 1 is no float64."""
    a = made_up.record_every_kind(tmp_path / "a", without="observation.pose")
    b = shutil.copytree(a, tmp_path / "b")
    file = tables.files_below(a / "data", ".parquet")[0].relative_to(a)
    for path, value in ((a, 2**53), (b, 2**53 + 1)):
        rows = pq.read_table(path / file)
        at = rows.column_names.index("observation.count")
        kind = pa.list_(pa.int64(), 1) if pa.types.is_nested(rows.schema.types[at]) else pa.int64()
        values = [[value] if pa.types.is_nested(kind) else value] * len(rows)
        pq.write_table(
            rows.set_column(at, "observation.count", pa.array(values, kind)), path / file
        )
    assert "changed" in kinds(compare_datasets(a, b))


@pytest.mark.parametrize("wrong", [3, "x", [[1], [2, 3]], {}, None, {"a": "\x1b[2J"}])
def test_whatever_stands_in_the_json_is_no_traceback(
    sound: Path, copy: Path, wrong: object
) -> None:
    file = copy / "meta/info.json"
    content = json.loads(file.read_text())
    places = [(key,) for key in content if key != "codebase_version"]
    for name in ("action", CAMERA):
        places += [("features", name, key) for key in content["features"][name]]
    for place in places:
        at = changed = json.loads(json.dumps(content))
        for key in place[:-1]:
            at = at[key]
        at[place[-1]] = wrong
        file.write_text(json.dumps(changed))
        try:
            found = compare_datasets(sound, copy)
        except DataError:
            continue
        assert json.dumps(found.as_json(), allow_nan=False), place
        assert all("\x1b" not in str(line) and "\n" not in str(line) for line in found.lines)


def test_nothing_commands_the_terminal(
    sound: Path, copy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    evil = "\x1b]0;owned\x07\x9b2J\u202ea\nb\ud800"
    feature("action", names=[evil] * 7)(copy)
    column(TASKS, "task", lambda v: v.__setitem__(0, evil[:-1]))(copy)
    table(EPISODES, lambda t: t.append_column(evil[:-1], pa.array([evil[:-1]] * 5)))(copy)
    odd = copy.rename(tmp_path / "a\x1b[31mb")
    for more in ([], ["--json"]):
        assert cli.main(["diff", str(sound), str(odd), *more]) == 1
        printed = capsys.readouterr().out
        assert "owned" in printed
        assert all(c.isprintable() or c == "\n" for c in printed)
    lines = printed.splitlines()
    assert lines


def test_what_is_printed_and_what_json_says(
    sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    edit.delete_episodes(sound, [0], tmp_path / "out")
    before = {p: p.stat().st_mtime_ns for p in tmp_path.rglob("*")}
    assert cli.main(["diff", str(sound), str(tmp_path / "out"), "--json"]) == 1
    content = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    found = compare_datasets(sound, tmp_path / "out")
    assert content["episodes"] == [5, 4]
    assert content["counts"] == found.counts
    assert content["counts"]["dropped"] == 1
    assert [one["kind"] for one in content["differences"]] == [d.kind for d in found.differences]
    assert content["differences"][0]["episodes"] == [[0, None]]
    assert cli.main(["diff", str(sound), str(tmp_path / "out")]) == 1
    printed = capsys.readouterr().out.splitlines()
    assert printed == [*map(str, found.lines), str(found)]
    assert f"B {tmp_path / 'out'}: 5 and 4 episodes: 0 the same; 1 dropped, 4 moved" in printed[-1]
    assert before == {p: p.stat().st_mtime_ns for p in tmp_path.rglob("*")}


def test_how_episodes_are_listed() -> None:
    assert listed([(3, None)]) == "episode 3"
    assert listed([(None, 4), (None, 5)]) == "episodes 4-5 of B"
    assert listed([(5, 5), (3, 3), (4, 4), (7, 7)]) == "episodes 3-5, 7"
    assert listed([(4, 3), (5, 4), (9, 2)]) == "episodes 4-5 (3-4 in B), 9 (2 in B)"
    assert len(listed([(i, None) for i in range(0, 9000, 2)])) <= 200
