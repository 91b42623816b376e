"""What is published, what is refused, and publishing to a folder."""

import re
import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from lfr import cli
from lfr.data.windows import read_dataset
from lfr.errors import DataError
from lfr.hub.publication import publication

NOWHERE = Path("none")


def publish(path: Path, folder: Path, *options: str) -> int:
    return cli.main(["publish", str(path), "--to", str(folder), "--results", "none", *options])


def contents(folder: Path) -> dict[str, bytes]:
    return {f.relative_to(folder).as_posix(): f.read_bytes()
            for f in folder.rglob("*") if f.is_file()}  # fmt: skip


def test_a_folder_holds_the_dataset_and_loads(dataset: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert publish(dataset, out, "--license", "cc-by-4.0") == 0
    files = contents(out)
    assert files.pop("README.md").startswith(b"---\nlicense: cc-by-4.0\n")
    assert files.pop("panda-lift.jpg").startswith(b"\xff\xd8")
    assert files == contents(dataset)
    assert np.array_equal(read_dataset(out).actions, read_dataset(dataset).actions)


def test_a_folder_is_replaced_but_never_one_with_other_things(
    dataset: Path, logs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert publish(dataset, out, "--with-logs", str(logs)) == 0
    assert publish(dataset, out) == 0
    assert not (out / "logs").exists()
    (out / "diary.txt").write_text("dear diary")
    assert publish(dataset, out) == 2
    assert "diary.txt" in capsys.readouterr().err
    assert (out / "diary.txt").read_text() == "dear diary"


def test_a_project_that_looks_alike_is_not_replaced(
    dataset: Path, models: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A folder of data with a README, and the folder in which all the models lie."""
    project, all_models = tmp_path / "project", tmp_path / "skills"
    for name in ("README.md", "data/mine.csv"):
        (project / name).parent.mkdir(parents=True, exist_ok=True)
        (project / name).write_text("mine")
    shutil.copytree(models, all_models / "s2-panda-stack")
    for what, folder in ((dataset, project), (models, all_models)):
        before = contents(folder)
        assert publish(what, folder) == 2
        assert "the folder holds other things" in capsys.readouterr().err
        assert contents(folder) == before


def test_models_replace_an_earlier_publication(models: Path, tmp_path: Path) -> None:
    out, link = tmp_path / "out", tmp_path / "link"
    link.symlink_to(out)
    assert publish(models, out) == publish(models, link) == 0
    assert link.is_symlink()
    assert {"README.md", "lift+stack/vae/config.json"} <= set(contents(out))


def test_what_is_behind_a_link_is_not_left_out_unsaid(
    dataset: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Videos on another disk; files that are links, as in the Hub's cache, are published."""
    copy, away = shutil.copytree(dataset, tmp_path / "panda-lift"), tmp_path / "away"
    camera = next((copy / "videos").iterdir())
    camera.rename(away)
    camera.symlink_to(away)
    assert publish(copy, tmp_path / "out") == 2
    assert f"a link that is not followed: {camera}" in capsys.readouterr().err
    camera.unlink()
    for video in away.rglob("*.mp4"):
        place = camera / video.relative_to(away)
        place.parent.mkdir(parents=True)
        place.symlink_to(video)
    assert publish(copy, tmp_path / "out") == 0
    assert set(contents(dataset)) < set(contents(tmp_path / "out"))
    assert not any(file.is_symlink() for file in (tmp_path / "out").rglob("*"))


def test_an_episode_without_a_log_is_told(dataset: Path, logs: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(dataset, tmp_path / "panda-lift")
    file = next((copy / "meta/episodes").rglob("*.parquet"))
    table = pq.read_table(file)
    at = table.column_names.index("log_file")
    names = pa.array([*table["log_file"].to_pylist()[:2], None])
    pq.write_table(table.set_column(at, "log_file", names), file)
    with pytest.raises(DataError, match=r"does not name its log.*episode 2"):
        publication(copy, repo_id=None, results=NOWHERE, logs=logs)


def test_a_dry_run_lists_every_file_and_writes_nothing(
    dataset: Path, logs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert publish(dataset, out, "--with-logs", str(logs), "--dry-run") == 0
    *listed, total = capsys.readouterr().out.splitlines()
    assert not out.exists()
    assert publish(dataset, out, "--with-logs", str(logs)) == 0
    sizes = {path: len(content) for path, content in contents(out).items()}
    found = {path: int(size.replace(",", "")) for size, path in map(str.split, listed)}
    assert found == sizes
    assert total.startswith(f"{len(sizes)} files, {sum(sizes.values()) / 1e6:.1f} MB")


def test_what_is_hidden_or_foreign_stays_here(dataset: Path, tmp_path: Path) -> None:
    copy = tmp_path / "panda-lift"
    shutil.copytree(dataset, copy)
    (copy / "data" / ".partial-file").write_bytes(b"?")
    (copy / "notes.txt").write_text("mine")
    planned = publication(copy, repo_id=None, results=NOWHERE)
    assert set(planned.files) == {*contents(dataset), "README.md", "panda-lift.jpg"}


@pytest.mark.parametrize("fault", ["another", "missing"])
def test_logs_of_another_dataset_are_refused(
    dataset: Path, logs: Path, tmp_path: Path, fault: str
) -> None:
    copy = tmp_path / "logs"
    shutil.copytree(logs, copy)
    first, second = sorted(copy.iterdir())[:2]
    first.unlink()
    if fault == "another":
        shutil.copyfile(second, first)
    with pytest.raises(DataError, match=first.name):
        publication(dataset, repo_id=None, results=NOWHERE, logs=copy)


def test_models_of_which_one_is_cut_off_are_refused(models: Path, tmp_path: Path) -> None:
    copy = tmp_path / "s1-panda-lift"
    shutil.copytree(models, copy)
    file = copy / "lift+stack" / "vae" / "model.safetensors"
    file.write_bytes(file.read_bytes()[:-10])
    with pytest.raises(DataError, match="vae"):
        publication(copy, repo_id=None, results=NOWHERE)


def test_without_results_it_says_what_the_card_lacks(
    dataset: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert publish(dataset, tmp_path / "out") == 0
    said = capsys.readouterr().err
    assert "no folder none here" in said
    assert "names no licence" in said
    assert "## Rebuild" not in (tmp_path / "out" / "README.md").read_text()


def test_the_documents_commands_parse(monkeypatch: pytest.MonkeyPatch) -> None:
    from lfr.hub import card_command, publish_command

    seen = []
    monkeypatch.setattr(publish_command, "run", seen.append)
    monkeypatch.setattr(card_command, "run", seen.append)
    text = (Path(__file__).parent.parent.parent / "docs" / "publish.md").read_text()
    lines = re.findall(r"^    lfr (.+?)(?:  +#.*)?$", text, re.MULTILINE)
    for line in lines:
        assert cli.main(line.split()) == 0
    assert len(seen) == len(lines) > 5


@pytest.mark.parametrize(
    "arguments",
    [["."], [".", "--repo", "nameless"], [".", "--to", "a", "--card", "b", "--license", "mit"],
     [".", "--to", "a", "--repo", "b/c"],
     [".", "--to", "a", "--private"], ["no/such/place", "--to", "a"], [".", "--to", "a"]],
)  # fmt: skip
def test_mistakes_are_told_in_a_line(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    try:
        code = cli.main(["publish", *arguments])
    except SystemExit as end:
        code = end.code
    assert code == 2
    assert "error: " in capsys.readouterr().err.splitlines()[-1]
    assert list(tmp_path.iterdir()) == []
