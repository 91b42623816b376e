"""Edited datasets hold the chosen episodes as they were, verify, and open in LeRobot."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from lfr import cli
from lfr.curation import clips, edit
from lfr.curation.clips import Clip, write_clip
from lfr.curation.contents import Contents
from lfr.curation.verify import verify_dataset
from lfr.data.stats import vector_stats
from lfr.errors import DataError, LfrError

from .broken import DATA, EPISODES, VIDEO, cut, info, put
from .conftest import LENGTHS

CAMERA = "observation.images.agentview"
OURS = ("seed", "success", "robot", "task_name", "log_file", "log_sha256")
ROWS = ("observation.state", "action", "next.reward", "next.done", "timestamp", "frame_index")


def rows_of(path: Path, column: str) -> list[np.ndarray]:
    """A column by episode."""
    contents = Contents.open(path)
    return np.split(contents.column(column), np.cumsum(contents.lengths)[:-1])


def assert_holds(path: Path, source: Path, episodes: list[int], at: int = 0) -> None:
    """Rows and columns of these episodes of `source`, from episode `at` of `path` on."""
    for column in ROWS:
        found, expected = rows_of(path, column), rows_of(source, column)
        for i, episode in enumerate(episodes):
            np.testing.assert_array_equal(found[at + i], expected[episode], err_msg=column)
    here, there = Contents.open(path).episodes, Contents.open(source).episodes
    for column in (*OURS, "tasks", "length", f"stats/{CAMERA}/q50", "stats/action/q01"):
        found = here[column].to_pylist()[at : at + len(episodes)]
        assert found == [there[column].to_pylist()[e] for e in episodes], column


def assert_opens(path: Path, sources: list[tuple[Path, int]]) -> None:
    """With LeRobot: the columns, and the first and last picture of each episode."""
    from lerobot.datasets import LeRobotDataset

    def opened(root: Path) -> Any:
        return LeRobotDataset("lfr/edited", root=root, video_backend="pyav")

    dataset = opened(path)
    assert dataset.num_episodes == len(sources)
    originals = {source: opened(source) for source, _ in sources}
    for i, (source, episode) in enumerate(sources):
        here, there = dataset.meta.episodes[i], originals[source].meta.episodes[episode]
        for column in OURS:
            assert here[column] == there[column]
        for end in ("dataset_from_index", "dataset_to_index"):
            last = int(end == "dataset_to_index")
            found, expected = dataset[here[end] - last], originals[source][there[end] - last]
            np.testing.assert_array_equal(found["action"], expected["action"])
            assert (int(found["episode_index"]), int(found["index"])) == (i, here[end] - last)
            # neighbouring frames are 10 levels of red apart, episodes 20 of blue
            difference = (found[CAMERA] - expected[CAMERA]).abs().mean(dim=(1, 2)) * 255
            assert float(difference.max()) < 4


def assert_verifies(path: Path) -> None:
    assert verify_dataset(path).findings == ()
    stats = json.loads((path / "meta/stats.json").read_text())
    contents = Contents.open(path)
    assert list(stats) == list(contents.features)
    for key in contents.numeric():
        for name, expected in vector_stats(contents.column(key)).items():
            np.testing.assert_allclose(stats[key][name], expected, rtol=1e-12, atol=1e-12)


def test_deleted_episodes_are_gone_and_the_others_whole(sound: Path, tmp_path: Path) -> None:
    counts = edit.delete_episodes(sound, [1, 3], tmp_path / "out")
    # 12, 9, 15, 7, 12 frames, every second a key frame: episode 2 starts at 21, episode 4 at 43
    assert counts == {"episodes": 3, "frames": 39, "copied": 0, "cut": 1, "encoded": 2}
    assert_holds(tmp_path / "out", sound, [0, 2, 4])
    assert_verifies(tmp_path / "out")
    assert_opens(tmp_path / "out", [(sound, 0), (sound, 2), (sound, 4)])
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_parts_put_together_again_are_the_whole(sound: Path, tmp_path: Path) -> None:
    counts = edit.split_episodes(sound, {"a": [0, 1], "b": [2, 3, 4]}, tmp_path / "parts")
    assert {name: c["episodes"] for name, c in counts.items()} == {"a": 2, "b": 3}
    for name, episodes in (("a", [0, 1]), ("b", [2, 3, 4])):
        assert_holds(tmp_path / "parts" / name, sound, episodes)
        assert_verifies(tmp_path / "parts" / name)
    merged = tmp_path / "merged"
    counts = edit.merge_datasets([tmp_path / "parts/a", tmp_path / "parts/b"], merged)
    assert counts == {"episodes": 5, "frames": 55, "copied": 2, "cut": 0, "encoded": 0}
    assert_holds(merged, sound, [0, 1, 2, 3, 4])
    assert_verifies(merged)
    assert_opens(merged, [(sound, i) for i in range(5)])
    assert pq.read_metadata(merged / DATA).num_row_groups == 5  # one each, as LeRobot has it
    whole, again = pq.read_table(sound / DATA), pq.read_table(merged / DATA)
    assert again.equals(whole)
    features = [json.loads(t.schema.metadata[b"huggingface"]) for t in (whole, again)]
    assert features[0] == features[1]


def test_other_tasks_get_indices_of_their_own(by_lerobot: Path, tmp_path: Path) -> None:
    """Episode 1 alone has the second task, which becomes the first."""
    edit.delete_episodes(by_lerobot, [0, 2], tmp_path / "second")
    assert set(Contents.open(tmp_path / "second").column("task_index")) == {0}
    edit.merge_datasets([tmp_path / "second", by_lerobot], tmp_path / "merged")
    contents = Contents.open(tmp_path / "merged")
    assert contents.info["total_tasks"] == 2
    assert contents.episodes["tasks"].to_pylist() == [["Return."], ["Reach."], ["Return."],
                                                     ["Reach."]]  # fmt: skip
    by_episode = rows_of(tmp_path / "merged", "task_index")
    assert [set(rows) for rows in by_episode] == [{0}, {1}, {0}, {1}]
    # and its quantiles are right, though the source's are averages; episode 0 is there again
    (finding,) = verify_dataset(tmp_path / "merged").findings
    assert (finding.check, finding.episode, finding.found) == ("duplicate", 2, "episode 0")


def test_a_column_that_one_dataset_has_not_is_empty_there(sound: Path, tmp_path: Path) -> None:
    marked = shutil.copytree(sound, tmp_path / "marked")
    table = pq.read_table(marked / EPISODES)
    pq.write_table(table.append_column("operator", pa.array(["ann"] * 5)), marked / EPISODES)
    edit.delete_episodes(marked, [1, 2, 3, 4], tmp_path / "first")
    edit.delete_episodes(sound, [0, 2, 3, 4], tmp_path / "second")
    edit.merge_datasets([tmp_path / "first", tmp_path / "second"], tmp_path / "merged")
    assert Contents.open(tmp_path / "merged").episodes["operator"].to_pylist() == ["ann", None]


def test_a_bad_episode_can_be_taken_out(dataset: Path, tmp_path: Path) -> None:
    put(DATA, "next.reward", 14, float("nan"))(dataset)
    assert verify_dataset(dataset).errors
    edit.delete_episodes(dataset, [1], tmp_path / "out")
    assert_verifies(tmp_path / "out")
    with pytest.raises(DataError, match=r"NaN or infinite.*column next.reward"):
        edit.delete_episodes(dataset, [0], tmp_path / "bad")
    assert not (tmp_path / "bad").exists()
    assert not list(tmp_path.glob(".*"))


@pytest.mark.parametrize(
    ("first", "frames", "how"),
    [(0, 55, "copied"), (12, 9, "cut"), (0, 21, "cut"), (21, 15, "encoded")],
)
def test_a_cut_video_is_the_same_pictures(
    sound: Path, tmp_path: Path, first: int, frames: int, how: str
) -> None:
    import av

    def pictures(path: Path) -> np.ndarray:
        with av.open(str(path)) as video:
            return np.stack([f.to_ndarray(format="rgb24") for f in video.decode(video=0)])

    info = Contents.open(sound).features[CAMERA]["info"]
    assert write_clip(Clip(sound / VIDEO, first, frames), tmp_path / "a.mp4", 20, info) == how
    found, whole = pictures(tmp_path / "a.mp4"), pictures(sound / VIDEO)
    expected = whole[first : first + frames]
    if how == "encoded":
        assert np.abs(found.astype(int) - expected).mean() < 2
    else:
        np.testing.assert_array_equal(found, expected)


def test_a_large_dataset_is_split_into_files(
    sound: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lfr.curation.assembled_rows.MEGABYTES", 0.002)
    small = shutil.copytree(sound, tmp_path / "small")
    info = json.loads((small / "meta/info.json").read_text())
    info.pop("data_files_size_in_mb")
    (small / "meta/info.json").write_text(json.dumps({**info, "chunks_size": 2}))
    edit.delete_episodes(small, [3], tmp_path / "out")
    files = sorted(p.relative_to(tmp_path / "out") for p in tmp_path.glob("out/data/*/*"))
    assert len(files) > 2
    assert str(files[2]) == "data/chunk-001/file-000.parquet"
    assert_holds(tmp_path / "out", sound, [0, 1, 2, 4])
    assert_verifies(tmp_path / "out")


def test_what_is_refused_leaves_nothing(
    sound: Path, by_lerobot: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    for call, message in (
        (lambda: edit.delete_episodes(sound, [5], out), r"no such episode.*expected 0 to 4"),
        (lambda: edit.delete_episodes(sound, range(5), out), "no episodes are left"),
        (lambda: edit.split_episodes(sound, {"a": [0], "b": [7]}, out), "no such episode"),
        (lambda: edit.split_episodes(sound, {"a": [0, 1], "b": [1]}, out), "'a' and in 'b'"),
        (lambda: edit.merge_datasets([sound, by_lerobot], out), "another kind.*column fps"),
        (lambda: edit.merge_datasets([sound, tmp_path / "no"], out), "no such dataset"),
    ):
        with pytest.raises(LfrError, match=message):
            call()
    monkeypatch.setattr(clips, "_cut", lambda clip, path, fps: shutil.copy(clip.source, path))
    with pytest.raises(DataError, match=r"not written whole.*found 55, expected 12"):
        edit.delete_episodes(sound, [1, 2, 3, 4], out)
    assert list(tmp_path.iterdir()) == []
    out.mkdir()
    with pytest.raises(LfrError, match="is there already"):
        edit.merge_datasets([sound], out)
    assert list(out.iterdir()) == []


def test_the_commands(sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    d, s, m = (str(tmp_path / name) for name in "dsm")
    assert cli.main(["edit", "delete", str(sound), "--episodes", "0,3-4", "--out", d]) == 0
    assert cli.main(["edit", "split", str(sound), "a=0.4", "b=0.6", "--out", s]) == 0
    assert cli.main(["edit", "merge", f"{s}/a", f"{s}/b", "--out", m]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(f"{d}: 2 episodes, {LENGTHS[1] + LENGTHS[2]} frames")
    assert [line.split(":")[1].split(",")[0] for line in lines] == [
        " 2 episodes", " 2 episodes", " 3 episodes", " 5 episodes",
    ]  # fmt: skip
    for taken, message in ((m, "is there already"), (f"{m}2", "same log as another episode's")):
        assert cli.main(["edit", "merge", f"{s}/b", d, "--out", taken]) == 2  # both have 2
        assert message in capsys.readouterr().err


def test_what_is_written_on_the_command_line(sound: Path) -> None:
    assert edit.parse_episodes("0,3,7-9", sound) == [0, 3, 7, 8, 9]
    assert edit.parse_splits(["a=0-1,4", "b=2"], sound) == {"a": [0, 1, 4], "b": [2]}
    assert edit.parse_splits(["a=0.8", "b=0.2"], sound) == {"a": [0, 1, 2, 3], "b": [4]}
    for text in ("", "a", "1-", "-1", "1,,2"):
        with pytest.raises(LfrError, match=r"expected such as 0,3,7-9"):
            edit.parse_episodes(text, sound)
    for texts in (["a"], ["a="], ["=1"], ["a=0", "a=1"], ["a=0.9", "b=0.2"], ["a=0.5", "b=x"]):
        with pytest.raises(LfrError, match=r"parts: "):
            edit.parse_splits(texts, sound)


def test_the_file_that_cannot_be_read_is_named(sound: Path, tmp_path: Path) -> None:
    """The source's, not the one that was to be written."""
    damaged = shutil.copytree(sound, tmp_path / "damaged")
    cut(DATA, 0.6)(damaged)
    with pytest.raises(DataError, match=f"cut-off Parquet: {damaged / DATA}"):
        edit.delete_episodes(damaged, [0], tmp_path / "out")
    edit.delete_episodes(sound, [1, 2, 3, 4], tmp_path / "first")
    with pytest.raises(DataError, match=f"cut-off Parquet: {damaged / DATA}"):
        edit.merge_datasets([tmp_path / "first", damaged], tmp_path / "out")
    unknown = shutil.copytree(sound, tmp_path / "unknown")
    put(DATA, "task_index", 30, 7)(unknown)
    with pytest.raises(DataError, match=r"a task without words.*episode 2.*found 7"):
        edit.delete_episodes(unknown, [0], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_nothing_is_written_outside_of_the_new_dataset(sound: Path, tmp_path: Path) -> None:
    """Paths come out of an info.json that anybody may have written."""
    theirs = shutil.copytree(sound, tmp_path / "theirs")
    outside = tmp_path / "outside"
    for path in (f"{outside}/{{chunk_index}}-{{file_index}}", "../../outside/{file_index}"):
        info(data_path=path)(theirs)
        with pytest.raises(DataError, match="a path that leads out of the dataset"):
            edit.delete_episodes(theirs, [0], tmp_path / "out")
        with pytest.raises(LfrError, match="one of a folder"):
            edit.split_episodes(sound, {"../../outside": [0]}, tmp_path / "out")
    assert {p.name for p in tmp_path.iterdir()} == {"theirs"}


def test_an_outcome_that_one_dataset_does_not_say_may_be_empty(sound: Path, tmp_path: Path) -> None:
    edit.split_episodes(sound, {"a": [0], "b": [1]}, tmp_path / "parts")
    second = tmp_path / "parts/b"
    table = pq.read_table(second / EPISODES)
    pq.write_table(table.drop_columns(list(OURS)), second / EPISODES)
    edit.merge_datasets([tmp_path / "parts/a", second], tmp_path / "merged")
    assert Contents.open(tmp_path / "merged").episodes["success"].to_pylist() == [True, None]
    assert not verify_dataset(tmp_path / "merged").errors


def test_what_would_be_there_twice_is_refused(sound: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    for call, message in (
        (lambda: edit.split_episodes(sound, {"a": [0, 0]}, out), "named twice"),
        (lambda: edit.merge_datasets([sound, sound / "../panda-lift"], out), "found .* twice"),
        (lambda: edit.parse_episodes("0,9-7", sound), "ends before it begins"),
    ):
        with pytest.raises(LfrError, match=message):
            call()
    assert not out.exists()
