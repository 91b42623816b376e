"""What is published, what is refused, and publishing to a folder."""

import re
import shutil
from pathlib import Path

import numpy as np
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
    assert publish(dataset, out) == 0
    files = contents(out)
    assert files.pop("README.md").startswith(b"---\nlicense: apache-2.0\n")
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
    file = copy / "source" / "vae" / "model.safetensors"
    file.write_bytes(file.read_bytes()[:-10])
    with pytest.raises(DataError, match="vae"):
        publication(copy, repo_id=None, results=NOWHERE)


def test_without_results_it_says_what_the_card_lacks(
    dataset: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert publish(dataset, tmp_path / "out") == 0
    assert "no folder none here" in capsys.readouterr().err
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
    [["."], [".", "--repo", "nameless"], [".", "--to", "a", "--repo", "b/c"],
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
