"""The benchmark of dataset checkers: what is planted, what counts as found, what is counted."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.checkers.bases import make_bases
from benchmarks.checkers.dataset_copy import EPISODE_ROWS, ROWS, DatasetCopy
from benchmarks.checkers.faults import CONTROL, FAULTS, GROUPS, plant
from benchmarks.checkers.faults.fault import ROW, K
from benchmarks.checkers.findings import Said, said
from benchmarks.checkers.page import MARKER, PAGE, SUMMARY, shown_on_page, table
from benchmarks.checkers.page import ROWS as TABLE
from benchmarks.checkers.results import (
    CLEAN,
    CRASH,
    FOUND,
    MISSED,
    OTHER,
    Row,
    alarms,
    by_group,
    complete,
    judged,
    not_found,
    of_clean,
    only,
    read_rows,
    total,
    write_rows,
)
from lfr.artifacts import read_json
from lfr.curation.contents import INFO, STATS, TASKS
from lfr.curation.verify import verify_dataset
from lfr.evaluation.marked import shown
from tests.curation import made_up

LENGTHS = (*[31] * K, 90, *[33] * 5)
VIDEO, ARM_VIDEO = (
    f"videos/observation.images.{camera}/chunk-000/file-000.mp4" for camera in ("agentview", "top")
)


@pytest.fixture(scope="module")
def bases(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Clean datasets like those that are recorded, of random numbers."""
    from lfr.data.dataset import pack_dataset

    made = tmp_path_factory.mktemp("made")
    pack_dataset(made_up.write_all(made / "logs", LENGTHS, 96), made / "own")
    make_bases(made / "bases", made / "own", made / "logs", ("arm", "arm2d"))
    return made / "bases"


def contents(root: Path) -> dict[str, object]:
    """Each file's content, links as links."""
    files = [file for file in root.rglob("*") if not file.is_dir()]
    return {
        str(file.relative_to(root)): "a link" if file.is_symlink()
        else hashlib.sha256(file.read_bytes()).hexdigest()
        for file in files
    }  # fmt: skip


MEANT = {
    "nan_action": {ROWS},
    "nan_2d": {ROWS},
    "action_outside_bounds": {ROWS, EPISODE_ROWS, STATS},
    "rows_swapped": {ROWS},
    "frame_dropped_renumbered": {ROWS, EPISODE_ROWS, STATS, INFO},
    "time_drift": {ROWS, EPISODE_ROWS, STATS},
    "fps_30_in_info": {INFO},
    "length_wrong": {EPISODE_ROWS},
    "total_frames_wrong": {INFO},
    "names_count_wrong": {INFO},
    "action_pickled_objects": {ROWS},
    "info_absent": {INFO},
    "stats_std_zero": {STATS},
    "task_empty_words": {TASKS, EPISODE_ROWS},
    "tasks_same_words_twice": {TASKS, INFO},
    "done_early": {ROWS, EPISODE_ROWS, STATS},
    "data_parquet_truncated": {ROWS},
    "video_bits_flipped": {VIDEO},
    "left_over_data_file": {ROWS.replace("000.parquet", "001.parquet")},
    "log_changed": set(),
    "symlink_out": {ROWS},
    "null_in_episode_length": {EPISODE_ROWS},
    "video_to_timestamp_wrong": {EPISODE_ROWS},
    "video_codec_wrong_in_info": {INFO},
    "pictures_black_episode": {VIDEO, EPISODE_ROWS, STATS},
    "pictures_of_another_episode": {VIDEO},
    "state_stuck_2s": {ROWS, EPISODE_ROWS, STATS},
    "episode_twice": {ROWS, EPISODE_ROWS, STATS, INFO, ARM_VIDEO},
    "unchanged_own": set(),
}


@pytest.mark.parametrize("name", MEANT)
def test_a_fault_is_where_it_is_meant(bases: Path, name: str, tmp_path: Path) -> None:
    clean = bases / FAULTS[name].base
    before = contents(clean)
    copy = plant(name, bases, tmp_path / name)
    found = contents(copy.root)
    differ = {file for file in before | found if before.get(file) != found.get(file)}
    assert differ == MEANT[name]
    assert contents(clean) == before  # nothing was written through a link


def test_every_group_has_a_fault_here() -> None:
    assert {FAULTS[name].group for name in MEANT} == set(GROUPS)


def test_only_the_meant_values_differ(bases: Path, tmp_path: Path) -> None:
    clean = DatasetCopy(bases / "arm")
    span = clean.span(K)
    stuck = plant("state_stuck_2s", bases, tmp_path / "stuck")
    state = clean.values("observation.state") != DatasetCopy(stuck.root).values("observation.state")
    assert state[span.start + 41 : span.start + 80].any(axis=1).all()
    state[span.start + 41 : span.start + 80] = False
    assert not state.any()
    nan = plant("nan_action", bases, tmp_path / "nan")
    assert np.argwhere(np.isnan(DatasetCopy(nan.root).values("action"))).tolist() == [
        [DatasetCopy(bases / "own").span(K).start + ROW, 2]
    ]
    log = plant("log_changed", bases, tmp_path / "log")
    one, other = (contents(folder) for folder in (log.logs, bases / "own-logs"))
    assert [name for name in one if one[name] != other[name]] == [f"episode-{K:06d}.mcap"]


def test_statistics_are_true_again_and_nothing_is_wrong_but_what_is_meant(
    bases: Path, tmp_path: Path
) -> None:
    """Of rows that were put together anew, LeRobot's own reader and our checks find nothing."""
    from lerobot.datasets import LeRobotDataset

    sound = {"spike", "noise", "jump", "tracking", "constant", "repeated-rows", "lag", "stuck"}
    copy = plant("counted_again_arm", bases, tmp_path / "again")
    assert {f.check for f in verify_dataset(copy.root).findings} <= sound  # of random numbers
    copy = plant("two_episodes_in_one", bases, tmp_path / "two")
    errors = [f for f in verify_dataset(copy.root).findings if f.severity == "error"]
    assert not errors
    opened = LeRobotDataset("made-up/two", copy.root, video_backend="pyav")
    assert opened.num_episodes == len(LENGTHS) - 1
    assert opened[len(opened) - 1]["episode_index"] == len(LENGTHS) - 2


@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n, f in FAULTS.items() if f.group != CONTROL])
def test_every_fault_changes_something(bases: Path, name: str, tmp_path: Path) -> None:
    copy = plant(name, bases, tmp_path / name)
    assert copy.logs.is_dir() or contents(copy.root) != contents(bases / FAULTS[name].base)


def test_what_is_said_is_compared_without_numbers() -> None:
    report = {
        "status": "failed",
        "episodes": 20,
        "results": [
            {"check_id": "gap", "severity": "WARN", "message": "0.51 s in episode 7 of /d/x/data"},
            {"check_id": "whole", "severity": "PASS", "message": "fine"},
            {"check_id": "jerk", "severity": "high", "title": "rough", "episodes": [3, 11]},
            {"check_id": "joint", "severity": "fail", "message": "joint_3 is still: 12.5 %"},
        ],
        "each": [{"episode_id": "x::episode_000004", "checks": {"lag": {"status": "fail"}}}],
        "scored": [
            {"episode_index": 5, "quality": "FLAG", "reasons": ["jittery: 2.1 times", "slow"]},
            {"episode_index": 6, "quality": "ok", "reasons": []},
        ],
    }
    found = said(1, f"log\n{json.dumps(report)}", "", None, Path("/d/x"))
    assert not found.crash
    assert found.lines == {
        "gap # s in episode # of DATASET/data [7]", "jerk rough [3]", "jerk rough [11]",
        "joint joint_3 is still: # %", "/each/checks/lag [4]", "/scored jittery: # times slow [5]",
    }  # fmt: skip
    report["results"][0]["message"] = "0.62 s in episode 7 of /d/x/data"
    assert said(1, json.dumps(report), "", None, Path("/d/x")) == found


def test_an_error_is_said_and_a_traceback_is_a_crash(tmp_path: Path) -> None:
    report, dataset = tmp_path / "report.json", Path("/d/x")
    assert said(2, "", "error: no info.json: /d/x\n", report, dataset).lines == {
        "error: no info.json: DATASET"
    }
    crash = said(1, "", "Traceback (most recent call last):\n  a\nKeyError: 'fps'\n", None, dataset)
    assert (crash.crash, crash.lines) == ("KeyError: 'fps'", frozenset())
    lost = "Traceback (most recent call last):\nFormatError: not found: /d/x/data/file.parquet"
    assert said(1, "", lost, None, dataset).crash == (
        "FormatError: not found: DATASET/data/file.parquet"
    )
    assert said(-9, "", "", None, dataset).crash
    assert said(None, "", "", None, dataset).crash
    assert said(0, "all is well", "", None, dataset) == Said(frozenset())
    report.write_text('[{"severity": "error", "message": "bad"}]')
    assert said(1, "", "Traceback (most recent call last)", report, dataset).lines == {" bad"}


def test_found_is_what_is_new_and_fits() -> None:
    clean = Said(frozenset({"length short [3]"}))

    def of(*lines: str, crash: str = "", name: str = "nan_action") -> str:
        return judged(name, "lfr", "1", clean, Said(frozenset(lines), crash)).result

    assert of("length short [3]") == MISSED
    assert of("length short [3]", "not-finite NaN [7]") == FOUND
    assert of("length short [7]") == OTHER
    assert of(crash="KeyError") == CRASH
    assert of("length short [3]", name="unchanged_own") == MISSED
    assert of("length short [4]", name="unchanged_own") == OTHER


ROWS_OF_TABLE = [
    Row("nan_action", "values", "lfr", "a", FOUND, "NaN"),
    Row("nan_state", "values", "lfr", "a", OTHER, "something"),
    Row("names_missing", "schema", "lfr", "a", MISSED),
    Row("nan_action", "values", "doctor", "0.2.0", MISSED),
    Row("nan_state", "values", "doctor", "0.2.0", OTHER, "something, else"),
    Row("names_missing", "schema", "doctor", "0.2.0", CRASH, "KeyError"),
    Row("unchanged_own", CONTROL, "doctor", "0.2.0", OTHER, "more"),
    Row("unchanged_own", CONTROL, "lfr", "a", MISSED),
    of_clean("own", "lfr", "a", Said(frozenset())),
    of_clean("own", "doctor", "0.2.0", Said(frozenset({"b", "a"}))),
]


def test_counts_are_of_the_rows(tmp_path: Path) -> None:
    write_rows(tmp_path / "table.csv", ROWS_OF_TABLE)
    rows = read_rows(tmp_path / "table.csv")
    assert sorted(map(repr, rows)) == sorted(map(repr, ROWS_OF_TABLE))
    groups = by_group(rows)
    # of this project's, words have to fit; of others', any do
    assert groups["lfr"] == {"values": (1, 2), "schema": (0, 1)}
    assert groups["doctor"] == {"values": (1, 2), "schema": (0, 1)}
    assert total(groups["lfr"]) == (1, 3)
    assert alarms(rows) == {"lfr": (0, 2), "doctor": (2, 2)}
    assert complete(rows) == []
    every = [Row(name, fault.group, "lint", "1", MISSED) for name, fault in FAULTS.items()]
    assert complete([*rows, *every]) == every
    assert complete([*rows, *every[1:]]) == []
    assert only(rows) == ["nan_action"]
    assert only(rows, "doctor") == ["nan_state"]
    assert not_found(rows) == ["nan_state", "names_missing"]
    text = table(rows, {"seconds": {"lfr": 1.26}, "versions": {"doctor": "0.2.0"}})
    assert "| **`lfr verify`** | 1 of 3 | 1 of 2 | 0 of 1 |" in text
    assert "| lerobot-doctor 0.2.0 | 1 of 3 |" in text
    assert "no other (1): nan action." in text


def test_the_page_shows_the_table_of_the_results() -> None:
    rows = read_rows(TABLE)
    assert shown(PAGE, MARKER) == shown_on_page()
    own = [row for row in rows if row.checker == "lfr" and row.group != CLEAN]
    assert {row.fault for row in own} == set(FAULTS)
    assert {row.group: FAULTS[row.fault].group for row in own} == {g: g for g in GROUPS}
    assert all(figure["reached"] for figure in read_json(SUMMARY)["figures"])
