"""What the files themselves say is mended as it was; what would be a guess is left, and said."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from lfr import cli
from lfr.curation.contents import Contents
from lfr.curation.repair import apply
from lfr.curation.repair.cut_json import whole_entries
from lfr.curation.repair.plan import planned
from lfr.curation.verify import verify_dataset
from lfr.data.stats import vector_stats
from lfr.errors import LfrError

from .broken import (
    BROKEN,
    CAMERA,
    DATA,
    EPISODES,
    TASKS,
    VIDEO,
    column,
    copied,
    cut,
    in_two_files,
    json_of,
    put,
    removed,
    table,
)

Break = Callable[[Path], object]
INFO, STATS = "meta/info.json", "meta/stats.json"
PICTURE_QUANTILES = {f"{CAMERA}/{q}" for q in ("q01", "q10", "q50", "q90", "q99")}
"""Of which a dataset's are averages of the episodes', since no picture is decoded."""

MENDED = [
    "episodes miscounted", "frames miscounted", "tasks miscounted", "a split beyond",
    "another length", "an empty episode", "another's rows", "rows of no episode",
    "episodes in no order", "an episode in pieces", "index", "frame index",
    "no fps", "another fps", "no path", "LeRobot's column unknown",
    "tasks cut off", "tasks missing", "stats cut off",
    "stats missing", "a mean", "a deviation", "a quantile", "a count", "NaN statistics",
    "statistics of another shape", "no statistics", "a statistic missing", "pixels",
    "pixels beyond", "pixels of which some are missing", "no table of statistics",
    "an episode's mean", "an episode's quantile", "another end", "another's frames",
    "between two frames",
]  # fmt: skip
LEFT = [
    "rows cut off", "rows empty", "rows missing", "video cut off", "video not finalized",
    "video missing", "a video too many", "pictures left", "an unfinished file", "a column missing",
    "too few names", "no shape", "another dtype", "another shape", "ragged",
    "video of another size", "a link out", "rows gone", "a gap", "a jump back", "no time",
    "a late start", "a drift", "a task without words", "empty words", "control characters",
    "other tasks", "NaN", "infinite", "null", "a shorter video",
    "a slower video", "another outcome", "a held-out seed", "a log twice",
]  # fmt: skip


def mended(dataset: Path, out: Path) -> list[str]:
    """Write a mended copy; gives back why something is not mended."""
    with planned(dataset) as plan:
        assert plan.draft.changed, plan.reasons
        assert len(plan.repairs) >= len(plan.draft.changed) > 0
        apply.write_new(plan.draft, out)
        return plan.reasons


def assert_same(found: Path, expected: Path, but: set[str] = frozenset()) -> None:  # pyright: ignore[reportArgumentType]
    """Every file, column by column; `but` are columns, or entries of JSON, that may differ."""
    names = {p.relative_to(expected).as_posix() for p in expected.rglob("*") if p.is_file()}
    assert {p.relative_to(found).as_posix() for p in found.rglob("*") if p.is_file()} == names
    for name in sorted(names):
        if name.endswith(".json"):
            same(*(json.loads((p / name).read_text()) for p in (found, expected)), "", but)
        elif name.endswith(".parquet"):
            tables = [pq.read_table(p / name) for p in (found, expected)]
            same(*(t.to_pydict() for t in tables), "", but)
            assert set(tables[0].schema) == set(tables[1].schema), name
        else:
            assert (found / name).read_bytes() == (expected / name).read_bytes()


def same(found: Any, expected: Any, where: str, but: set[str]) -> None:
    if where in but:
        return
    if isinstance(expected, dict):
        assert found.keys() == expected.keys(), where
        for key in expected:
            same(found[key], expected[key], f"{where}/{key}".strip("/"), but)
    elif found != expected:
        try:
            numbers = np.array(expected, np.float64)
        except (ValueError, TypeError):  # words, gaps
            pytest.fail(f"{where}: found {found}, expected {expected}")
        else:
            np.testing.assert_allclose(found, numbers, 1e-9, 1e-9, err_msg=where)


def assert_opens(path: Path, like: Path) -> None:
    """LeRobot reads the same rows and pictures as of the dataset that was never broken."""
    from lerobot.datasets import LeRobotDataset

    found, expected = (LeRobotDataset("lfr/x", root=p) for p in (path, like))
    assert len(found) == len(expected)
    for at in (0, len(expected) // 2, len(expected) - 1):
        for key, value in expected[at].items():
            np.testing.assert_array_equal(found[at][key], value)


def bytes_of(path: Path) -> dict[str, bytes]:
    return {p.relative_to(path).as_posix(): p.read_bytes() for p in path.rglob("*") if p.is_file()}


@pytest.mark.parametrize("name", MENDED)
def test_what_is_certain_is_as_it_was(dataset: Path, sound: Path, name: str) -> None:
    BROKEN[name][0](dataset)
    broken = bytes_of(dataset)
    with planned(dataset) as plan:
        assert plan.after.findings == ()
        assert plan.draft.changed
        assert len(plan.repairs) >= len(plan.draft.changed)
        assert_same(plan.draft.path, sound, PICTURE_QUANTILES)
    assert bytes_of(dataset) == broken


def test_what_is_lost_with_all_that_counts_it_is_not_made_anew(dataset: Path) -> None:
    table(DATA, lambda t: t.slice(0, 43))(dataset)
    removed(EPISODES)(dataset)
    with planned(dataset) as plan:
        assert not plan.draft.changed
        assert "43 rows are there, and 55" in plan.reasons[0]


@pytest.mark.parametrize("name", LEFT)
def test_what_is_not_certain_stays_as_it_is(dataset: Path, name: str) -> None:
    BROKEN[name][0](dataset)
    with planned(dataset) as plan:
        assert not plan.draft.changed, plan.repairs
        assert plan.after.findings == plan.before.findings != ()


def test_several_faults_at_once(dataset: Path, sound: Path, tmp_path: Path) -> None:
    for name in ("index", "another length", "another end", "a mean", "frames miscounted",
                 "tasks missing", "an episode's mean", "no fps"):  # fmt: skip
        BROKEN[name][0](dataset)
    mended(dataset, tmp_path / "new")
    assert_same(tmp_path / "new", sound)
    assert_opens(tmp_path / "new", sound)


def test_a_sound_dataset_has_nothing_to_mend(
    dataset: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = bytes_of(dataset.parent)
    for options in ([], ["--in-place"], ["--out", str(dataset.parent / "new")]):
        assert cli.main(["verify", str(dataset), "--fix", *options]) == 0
        assert capsys.readouterr().out.splitlines()[-1] == "nothing to mend"
    assert bytes_of(dataset.parent) == before


def test_averaged_quantiles_become_those_of_the_rows(by_lerobot: Path, tmp_path: Path) -> None:
    mended(by_lerobot, tmp_path / "new")
    assert verify_dataset(tmp_path / "new").findings == ()
    stats = json.loads((tmp_path / "new" / STATS).read_text())
    contents = Contents.open(tmp_path / "new")
    for key in ("action", "observation.state"):
        for name, expected in vector_stats(contents.column(key)).items():
            np.testing.assert_allclose(stats[key][name], expected, rtol=1e-12)
    unchanged = {k: v for k, v in bytes_of(by_lerobot).items() if k != STATS}
    assert {k: v for k, v in bytes_of(tmp_path / "new").items() if k != STATS} == unchanged
    with planned(tmp_path / "new") as plan:
        assert not plan.repairs


@pytest.mark.parametrize(
    "damage",
    [removed(INFO), cut(INFO, 0.0), json_of(INFO, lambda i: i.clear())],
    ids=["missing", "empty", "nothing in it"],
)
def test_a_lost_info_is_told_from_the_files(
    dataset: Path, sound: Path, tmp_path: Path, damage: Break
) -> None:
    damage(dataset)
    mended(dataset, tmp_path / "new")
    found, expected = (json.loads((p / INFO).read_text()) for p in (tmp_path / "new", sound))
    assert found.keys() == expected.keys()
    assert found["robot_type"] is None
    for key, feature in expected["features"].items():
        there = found["features"][key]
        assert [there[n] for n in ("dtype", "shape")] == [feature[n] for n in ("dtype", "shape")]
        if key == CAMERA:
            encoder = {n for n in feature["info"] if n not in there["info"]}
            assert encoder == {"video.g", "video.crf", "video.preset", "video.fast_decode",
                               "video.video_backend", "video.extra_options"}  # fmt: skip
            assert there["info"].items() <= feature["info"].items()
            assert there["names"] == feature["names"]
        else:
            assert there["names"] is None
    same(found, expected, "", {"robot_type", "features"})
    assert not verify_dataset(tmp_path / "new").errors
    assert_same(tmp_path / "new", sound, {"robot_type", "features"})
    assert_opens(tmp_path / "new", sound)


def advice(dataset: Path, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Lines of `lfr verify` that name `--fix`; nothing of it is for machines to read."""
    cli.main(["verify", str(dataset)])
    cli.main(["verify", str(dataset), "--json"])
    printed = capsys.readouterr()
    assert "--fix" not in printed.out
    return [line for line in printed.err.splitlines() if "--fix" in line]


@pytest.mark.parametrize("damage", [removed(INFO), cut(INFO, 0.0), cut(INFO, 0.5),
                                    json_of(INFO, lambda i: i.clear())])  # fmt: skip
def test_a_lost_info_leads_to_fix(
    dataset: Path, damage: Break, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    damage(dataset)
    said = advice(dataset, capsys)
    assert len(said) == 2
    assert said[0].endswith(f"`lfr verify {dataset} --fix` rebuilds it from the other files")
    assert cli.main(["verify", str(dataset), "--fix", "--out", str(tmp_path / "new")]) == 0


@pytest.mark.parametrize(
    "damage",
    [
        lambda d: column(DATA, "timestamp", lambda v: v.__setitem__(slice(None), [0.0] * len(v)))(
            d
        ),
        removed(DATA),
        cut(DATA, 0.5),
        lambda d: (d / DATA).rename(d / "data/chunk-000/rows.parquet"),
    ],
)
def test_what_fix_cannot_rebuild_does_not_lead_to_it(
    dataset: Path, damage: Break, capsys: pytest.CaptureFixture[str]
) -> None:
    damage(dataset)
    for lost in (cut(INFO, 0.0), removed(INFO)):
        lost(dataset)
        assert not advice(dataset, capsys)
        cli.main(["verify", str(dataset), "--fix"])
        assert f"would mend: {INFO}: " not in capsys.readouterr().out


def test_of_an_info_that_was_cut_off_the_rest_is_kept(
    dataset: Path, sound: Path, tmp_path: Path
) -> None:
    text = (dataset / INFO).read_text()
    (dataset / INFO).write_text(text[: text.index('"next.done"')])
    mended(dataset, tmp_path / "new")
    found, expected = (json.loads((p / INFO).read_text()) for p in (tmp_path / "new", sound))
    assert found["features"]["action"] == expected["features"]["action"]
    assert found["features"]["next.done"]["names"] is None
    assert_opens(tmp_path / "new", sound)


def test_every_type_that_lerobot_records_is_described(tmp_path: Path) -> None:
    from . import made_up

    path = made_up.record_every_kind(tmp_path / "kinds")
    expected = json.loads((path / INFO).read_text())
    shutil.copytree(path, tmp_path / "lost")
    removed(INFO)(tmp_path / "lost")
    mended(tmp_path / "lost", tmp_path / "new")
    found = json.loads((tmp_path / "new" / INFO).read_text())
    for key, feature in expected["features"].items():
        assert found["features"][key]["dtype"] == feature["dtype"], key
        if feature["dtype"] == "image":  # LeRobot's axes in whichever order they are called
            assert found["features"][key]["shape"] == [32, 48, 3]
        else:
            assert found["features"][key]["shape"] == feature["shape"], key
    assert (found["fps"], found["total_frames"]) == (25, 80)
    assert not verify_dataset(tmp_path / "new").errors
    assert_opens(tmp_path / "new", path)


def test_lost_episodes_are_told_from_the_rows(dataset: Path, sound: Path, tmp_path: Path) -> None:
    removed(EPISODES)(dataset)
    reasons = mended(dataset, tmp_path / "new")
    assert "statistics of pictures" in reasons[0]
    found, expected = (pq.read_table(p / EPISODES).to_pydict() for p in (tmp_path / "new", sound))
    own = {"seed", "success", "robot", "task_name", "log_file", "log_sha256"}
    pictures = {name for name in expected if name.startswith(f"stats/{CAMERA}/")}
    assert expected.keys() - found.keys() <= own | pictures | {
        "meta/episodes/chunk_index", "meta/episodes/file_index"}  # fmt: skip
    for name in found:
        same(found[name], expected[name], name, set())
    assert verify_dataset(tmp_path / "new").findings == ()
    assert_opens(tmp_path / "new", sound)


def in_two_tables(dataset: Path) -> str:
    """Episodes 2 to 4 in a file of their own, which is named."""
    name = EPISODES.replace("file-000", "file-001")
    rows = pq.read_table(dataset / EPISODES)
    at = rows.column_names.index("meta/episodes/file_index")
    for file, part, number in ((name, rows.slice(2), 1), (EPISODES, rows.slice(0, 2), 0)):
        values = pa.array([number] * len(part))
        pq.write_table(part.set_column(at, "meta/episodes/file_index", values), dataset / file)
    return name


def test_of_several_files_of_episodes_the_lost_one_is_written(
    dataset: Path, tmp_path: Path
) -> None:
    name = in_two_tables(dataset)
    assert verify_dataset(dataset).findings == ()
    shutil.copytree(dataset, tmp_path / "whole")
    cut(name, 0.7)(dataset)
    mended(dataset, tmp_path / "new")
    files = [pq.read_table(tmp_path / "new" / file) for file in (EPISODES, name)]
    assert [t["episode_index"].to_pylist() for t in files] == [[0, 1], [2, 3, 4]]
    assert files[1]["meta/episodes/file_index"].to_pylist() == [1, 1, 1]
    assert files[1]["seed"].null_count == 3
    (finding,) = verify_dataset(tmp_path / "new").findings
    assert (finding.severity, finding.places) == ("warning", 3)  # their pictures' statistics
    assert_opens(tmp_path / "new", tmp_path / "whole")


def test_an_episode_that_is_missing_or_there_twice(
    dataset: Path, sound: Path, tmp_path: Path
) -> None:
    shutil.copytree(dataset, tmp_path / "twice")
    table(EPISODES, lambda t: t.take([0, 1, 2, 3, 3, 4]))(tmp_path / "twice")
    mended(tmp_path / "twice", tmp_path / "once")
    assert_same(tmp_path / "once", sound)
    table(EPISODES, lambda t: t.take([0, 1, 3, 4]))(dataset)
    mended(dataset, tmp_path / "new")
    assert verify_dataset(tmp_path / "new").errors == []
    found, expected = (pq.read_table(p / EPISODES) for p in (tmp_path / "new", sound))
    assert found.take([0, 1, 3, 4]).equals(expected.take([0, 1, 3, 4]))
    for name in expected.column_names:
        if name.startswith("stats/action"):
            np.testing.assert_allclose(found[name][2].as_py(), expected[name][2].as_py())


def test_episodes_whose_rows_are_in_another_file(dataset: Path, tmp_path: Path) -> None:
    in_two_files(dataset)
    mended(dataset, tmp_path / "new")
    assert verify_dataset(tmp_path / "new").findings == ()
    files = pq.read_table(tmp_path / "new" / EPISODES)["data/file_index"].to_pylist()
    assert files == [0, 0, 1, 1, 1]


@pytest.mark.parametrize(
    "order",
    [[*range(12, 21), *range(12), *range(21, 55)], [1, 0, *range(2, 55)]],
    ids=["episodes", "rows"],
)
def test_rows_that_say_where_they_belong_are_put_there(
    dataset: Path, sound: Path, tmp_path: Path, order: list[int]
) -> None:
    table(DATA, lambda t: t.take(order))(dataset)
    mended(dataset, tmp_path / "new")
    assert_same(tmp_path / "new", sound)


def test_what_is_lost_is_not_counted_away(dataset: Path, tmp_path: Path) -> None:
    """Rows at an episode's end: nothing of the rows themselves shows it."""
    table(DATA, lambda t: t.slice(0, 50))(dataset)
    with planned(dataset) as plan:
        assert not plan.draft.changed
        (reason,) = plan.reasons
    assert "episode 4 has 7 rows, and 12 by all that counts them" in reason


def test_new_numbers_do_not_hide_lost_time(dataset: Path) -> None:
    column(DATA, "timestamp", lambda v: v.__setitem__(16, v[15]))(dataset)
    column(DATA, "frame_index", lambda v: v.__setitem__(16, 90))(dataset)
    with planned(dataset) as plan:
        assert not plan.draft.changed
        assert "row 16" in plan.reasons[0] or "not certain which" in plan.reasons[0]


def test_episodes_that_have_changed_numbers_are_not_told_apart(dataset: Path) -> None:
    """Of one length, the first and the last: which is which, only their numbers say."""

    def swap(values: list[int]) -> None:
        values[:12], values[43:] = [4] * 12, [0] * 12

    column(DATA, "episode_index", swap)(dataset)
    with planned(dataset) as plan:
        assert not plan.draft.changed
        assert "not certain which rows are whose" in plan.reasons[0]


def test_rows_that_changed_after_their_statistics_are_not_called_right(
    dataset: Path, tmp_path: Path
) -> None:
    column(DATA, "action", lambda v: v[20].__setitem__(1, 0.999))(dataset)
    with planned(dataset) as plan:
        assert not plan.draft.changed
        assert "remove meta/stats.json" in plan.reasons[0]
    removed(STATS)(dataset)  # as it says, by someone who knows that the rows are right
    mended(dataset, tmp_path / "new")
    assert verify_dataset(tmp_path / "new").findings == ()


def test_words_are_told_by_the_episodes(by_lerobot: Path, tmp_path: Path) -> None:
    lost = shutil.copytree(by_lerobot, tmp_path / "lost")
    removed(TASKS)(lost)
    mended(lost, tmp_path / "new")
    found, expected = (pq.read_table(p / TASKS).to_pydict() for p in (tmp_path / "new", by_lerobot))
    assert found == expected
    assert_opens(tmp_path / "new", by_lerobot)
    shutil.copytree(lost, tmp_path / "either")
    column(EPISODES, "tasks", lambda v: v.__setitem__(slice(None), [["Reach.", "Return."]] * 3))(
        tmp_path / "either"
    )
    with planned(tmp_path / "either") as plan:
        assert TASKS not in plan.draft.changed
        assert any("which words are whose" in reason for reason in plan.reasons)


def test_pictures_that_fill_no_file_are_not_placed(dataset: Path) -> None:
    """A frame more than rows may be any episode's."""
    BROKEN["a longer video"][0](dataset)
    put(EPISODES, f"videos/{CAMERA}/from_timestamp", 2, 0.0)(dataset)
    with planned(dataset) as plan:
        assert plan.draft.changed == [STATS]
        assert "43 rows do not fill" in plan.reasons[0]


@pytest.mark.parametrize(
    ("key", "wrong"), [("video.codec", "h264"), ("video.pix_fmt", "gray"), ("video.fps", 30)]
)
def test_a_format_is_told_from_the_videos(
    dataset: Path, sound: Path, key: str, wrong: object
) -> None:
    json_of(INFO, lambda i: i["features"][CAMERA]["info"].update({key: wrong}))(dataset)
    with planned(dataset) as plan:
        assert_same(plan.draft.path, sound)


def test_pictures_in_several_files_are_placed(dataset: Path, tmp_path: Path) -> None:
    from lfr.curation import edit

    edit.split_episodes(dataset, {"a": [0, 1], "b": [2, 3, 4]}, tmp_path / "parts")
    whole = tmp_path / "whole"
    edit.merge_datasets([tmp_path / "parts/a", tmp_path / "parts/b"], whole)
    shutil.copytree(whole, tmp_path / "broken")
    for name in ("chunk_index", "file_index", "from_timestamp", "to_timestamp"):
        put(EPISODES, f"videos/{CAMERA}/{name}", 3, None)(tmp_path / "broken")
    mended(tmp_path / "broken", tmp_path / "new")
    assert_same(tmp_path / "new", whole)


def test_a_dry_run_says_all_and_writes_nothing(
    dataset: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    BROKEN["a mean"][0](dataset)
    BROKEN["a gap"][0](dataset)
    before = bytes_of(dataset.parent)
    assert cli.main(["verify", str(dataset), "--fix"]) == 1
    printed = capsys.readouterr().out
    assert f"would mend: {STATS}: computed anew: action (1 feature)\n" in printed
    assert "would be left: error: gap-in-time" in printed
    assert f"--fix --out NEW, a mended copy; or --in-place, the old files kept in {dataset}" in (
        printed
    )
    assert bytes_of(dataset.parent) == before
    assert cli.main(["verify", str(dataset), "--fix", "--json"]) == 1
    content = json.loads(capsys.readouterr().out)
    fix = content.pop("fix")
    assert fix["written"] is None
    assert [repair["file"] for repair in fix["repairs"]] == [STATS]
    assert fix["before"] == content["findings"]
    assert len(fix["after"]) < len(fix["before"])
    assert cli.main(["verify", str(dataset), "--json"]) == 1
    assert json.loads(capsys.readouterr().out) == content


def test_json_is_of_what_was_written(
    dataset: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """So what reads the one, `--accept` and `lfr view --findings`, reads the other."""
    from lfr.curation.saved_report import read_report

    BROKEN["a mean"][0](dataset)
    put(DATA, "timestamp", 16, 0.05)(dataset)
    new, file = tmp_path / "new", tmp_path / "report.json"
    assert cli.main(["verify", str(dataset), "--fix", "--out", str(new), "--json"]) == 1
    file.write_text(capsys.readouterr().out)
    content = json.loads(file.read_text())
    assert (content["path"], content["fix"]["written"]) == (str(new), str(new))
    assert content["findings"] == content["fix"]["after"] != content["fix"]["before"]
    assert [*map(str, read_report(file).findings)] == [*map(str, verify_dataset(new).findings)]
    assert cli.main(["verify", str(new), "--accept", str(file)]) == 0


def test_in_place_keeps_the_old_files(
    dataset: Path, sound: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    BROKEN["a mean"][0](dataset)
    BROKEN["index"][0](dataset)
    before = bytes_of(dataset)
    times = {p: p.stat().st_ino for p in dataset.rglob("*") if p.is_file()}
    assert cli.main(["verify", str(dataset), "--fix", "--in-place"]) == 0
    kept = dataset.with_name("panda-lift.before-fix")
    assert f"the old files are in {kept}" in capsys.readouterr().out
    assert_same(dataset, sound)
    changed = {name for name, content in bytes_of(dataset).items() if content != before[name]}
    assert changed == {DATA, STATS}
    assert bytes_of(kept) == {name: before[name] for name in changed}
    assert all((dataset / n).stat().st_ino == times[dataset / n] for n in before.keys() - changed)
    assert {p.name for p in dataset.parent.iterdir()} == {dataset.name, kept.name}
    BROKEN["a mean"][0](dataset)
    assert cli.main(["verify", str(dataset), "--fix", "--in-place"]) == 2
    assert "is there already" in capsys.readouterr().err


@pytest.mark.parametrize("after", range(6))
def test_a_kill_leaves_whole_files_and_a_second_run_ends_it(
    dataset: Path, sound: Path, monkeypatch: pytest.MonkeyPatch, after: int
) -> None:
    for name in ("index", "another length", "a mean", "frames miscounted", "tasks missing"):
        BROKEN[name][0](dataset)
    before = bytes_of(dataset)
    with planned(dataset) as plan:
        new = bytes_of(plan.draft.path)

        class KilledError(Exception):
            pass

        copies: list[Path] = []
        copy = shutil.copyfile

        def killed(source: Path, to: Path) -> None:
            copies.append(to)
            if len(copies) > after:
                to.write_bytes(b"half")
                raise KilledError
            copy(source, to)

        monkeypatch.setattr(apply.shutil, "copyfile", killed)
        if after < 5:
            with pytest.raises(KilledError):
                apply.replace_in_place(plan.draft, dataset)
        else:  # killed before the old files' folder got its name
            apply.replace_in_place(plan.draft, dataset)
            kept = apply.backup_of(dataset)
            kept.rename(kept.with_name(f".partial-{kept.name}"))
        monkeypatch.undo()
    for name, content in bytes_of(dataset).items():
        assert content in (before.get(name), new[name]), name
    assert cli.main(["verify", str(dataset), "--fix", "--in-place"]) == 0
    assert_same(dataset, sound)
    kept = bytes_of(apply.backup_of(dataset))
    assert kept == {name: before[name] for name in kept}
    assert kept.keys() == {DATA, EPISODES, STATS, INFO}  # tasks.parquet was not there


def test_where_a_copy_cannot_be_written(
    dataset: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    BROKEN["a mean"][0](dataset)
    (tmp_path / "there").mkdir()
    for options, said in (
        (["--fix", "--out", str(tmp_path / "there")], "is there already"),
        (["--fix", "--out", str(dataset / "new")], "is within"),
        (["--out", str(tmp_path / "new")], "expected --fix too"),
        (["--in-place"], "expected --fix too"),
    ):
        assert cli.main(["verify", str(dataset), *options]) == 2
        assert said in capsys.readouterr().err
    assert cli.main(["verify", str(tmp_path), "--fix"]) == 2


def test_links_are_read_and_not_written_through(dataset: Path, sound: Path, tmp_path: Path) -> None:
    """As in the Hub's store, where a dataset's files are links to files named by their content."""
    BROKEN["a mean"][0](dataset)
    store = tmp_path / "blobs"
    store.mkdir()
    for i, file in enumerate(sorted(p for p in dataset.rglob("*") if p.is_file())):
        file.rename(store / str(i))
        file.symlink_to(
            Path("../" * len(file.relative_to(tmp_path).parents[0].parts)) / f"blobs/{i}"
        )
    before = bytes_of(store)
    mended(dataset, tmp_path / "new")
    assert_same(tmp_path / "new", sound)
    assert not any(p.is_symlink() for p in (tmp_path / "new").rglob("*"))
    assert cli.main(["verify", str(dataset), "--fix", "--in-place"]) == 0
    assert_same(dataset, sound)
    assert bytes_of(store) == before
    assert (dataset / VIDEO).is_symlink()
    assert not (dataset / STATS).is_symlink()


def test_other_files_and_links_are_copied(dataset: Path, tmp_path: Path) -> None:
    BROKEN["a mean"][0](dataset)
    copied(INFO, "README.md")(dataset)
    (tmp_path / "elsewhere").write_text("x")
    (dataset / "out").symlink_to(tmp_path / "elsewhere")
    (dataset / "nowhere").symlink_to("nothing")
    mended(dataset, tmp_path / "new")
    assert (tmp_path / "new/README.md").read_bytes() == (dataset / "README.md").read_bytes()
    assert (tmp_path / "new/out").is_symlink()
    assert not (tmp_path / "new/nowhere").exists()


def test_entries_of_cut_json_are_those_of_the_whole(sound: Path) -> None:
    text = (sound / INFO).read_text()
    whole, most = json.loads(text), 0
    for end in range(0, len(text), 7):
        for key, value in whole_entries(text[:end]).items():
            if key == "features":
                assert value.items() <= whole[key].items()
                most = max(most, len(value))
            else:
                assert value == whole[key]
    assert most == len(whole["features"])
    assert whole_entries("[1, 2, ") == whole_entries("") == whole_entries('{"a": 1') == {}


def test_no_such_dataset(tmp_path: Path) -> None:
    with pytest.raises(LfrError, match="no such dataset"), planned(tmp_path / "absent"):
        pass
