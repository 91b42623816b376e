"""Datasets by their names on the Hub: what is fetched, which version, and what is said of none."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import huggingface_hub.constants as constants
import pytest

from lfr import cli
from lfr.curation.verify import verify_dataset
from lfr.data.opening import opened
from lfr.data.tables import DatasetFiles
from lfr.view.dataset import read_episode
from tests.curation import arm, older

from .conftest import TOKEN
from .server import LARGE, Hub, Repository

NAME = "theirs/arm-reach"


def put(hub: Hub, folder: Path, *tags: str, name: str = NAME) -> Repository:
    """Have the Hub hold a folder under `main`, and the tags at this commit of it."""
    repository = hub.repositories.setdefault(("dataset", name), Repository(private=False))
    tree = {
        file.relative_to(folder).as_posix(): (file.read_bytes(), file.name.endswith(LARGE))
        for file in folder.rglob("*")
        if file.is_file()
    }
    commit = repository.commit(tree, f"of {folder.name}, {tags}")
    repository.refs |= dict.fromkeys(tags, commit)
    return repository


@pytest.fixture(scope="module")
def new(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return arm.write(tmp_path_factory.mktemp("new") / "arm", arm.recording(4), pictures=True)


@pytest.fixture(scope="module")
def old(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return older.write(tmp_path_factory.mktemp("old") / "arm", arm.recording(3))


@pytest.fixture
def elsewhere(hub: Hub, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Hub:
    """The Hub, from an empty folder."""
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")
    return hub


def fetched(hub: Hub) -> set[str]:
    """Names of the files whose contents were asked for since the last time."""
    names = {m[1] for r in hub.requests if (m := re.match(r"GET .*/resolve/[^/]+/(.*)", r))}
    hub.requests.clear()
    return names


def test_all_of_it_is_verified(
    elsewhere: Hub, new: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    put(elsewhere, new, "v3.0")
    assert cli.main(["verify", NAME]) == 0
    here = [str(finding) for finding in verify_dataset(new).findings]
    printed = capsys.readouterr().out.splitlines()
    assert printed[:-1] == here
    assert printed[-1].startswith(f"{NAME}: 4 episodes")
    assert fetched(elsewhere) == {
        f.relative_to(new).as_posix() for f in new.rglob("*") if f.is_file()
    }
    assert cli.main(["verify", NAME]) == 0
    assert not fetched(elsewhere)  # it is in the cache


def test_no_more_is_fetched_than_is_read(elsewhere: Hub, old: Path, tmp_path: Path) -> None:
    """A list needs no pictures, an episode no other one's files."""
    put(elsewhere, old, "v2.1")
    states = arm.recording(3).states
    with opened(Path(NAME)) as path:
        assert fetched(elsewhere) == {f"meta/{f.name}" for f in (old / "meta").iterdir()}
        episode = read_episode(path, 1)
        assert fetched(elsewhere) == {older.data(1), older.video(1)}
        assert (episode.features[arm.STATE] == states[1]).all()
        assert len(episode.images["top"]) == len(states[1])
        assert path.name == "arm-reach"
    assert cli.main(["view", NAME, "--list"]) == 0
    assert not fetched(elsewhere)  # it has neither rewards nor successes, which are in the rows
    assert cli.main(["columns", NAME]) == 0
    assert fetched(elsewhere) == {older.data(0), older.data(2)}
    out = tmp_path / "two.rrd"
    assert cli.main(["view", NAME, "--episode", "2", "--side-by-side", f"{NAME}:0",
                     "--save", str(out)]) == 0  # fmt: skip
    assert fetched(elsewhere) == {older.video(0), older.video(2)}


def test_columns_says_how_a_stage_can_read_it(
    elsewhere: Hub, old: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    repository = put(elsewhere, old)
    assert cli.main(["columns", NAME]) == 0
    printed = capsys.readouterr().out
    assert f"path: {NAME}\n" in printed
    commit = repository.refs["main"]
    assert (
        f"hf download {NAME} --repo-type dataset --revision {commit} --local-dir {NAME}" in printed
    )
    assert "convert_dataset_v21_to_v30" in printed


def test_the_release_that_lerobot_takes(elsewhere: Hub, new: Path, old: Path) -> None:
    """The tag v3.0, or else v2.1, or else the main branch."""

    def version(revision: str | None = None) -> tuple[str, str]:
        with opened(Path(NAME), revision) as path:
            source = DatasetFiles.open(path).source
            return source.version, source.origin.name

    refs = put(elsewhere, old).refs
    assert version() == ("v2.1", refs["main"])
    put(elsewhere, old, "v2.1")
    put(elsewhere, new)
    assert version() == ("v2.1", refs["v2.1"])
    assert version("main") == ("v3.0", refs["main"])
    put(elsewhere, new, "v3.0")
    put(elsewhere, old)
    assert version() == ("v3.0", refs["v3.0"])
    assert version(refs["v2.1"]) == ("v2.1", refs["v2.1"])


def test_a_revision_behind_the_name(
    elsewhere: Hub, new: Path, old: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    refs = put(elsewhere, new, "v3.0").refs
    put(elsewhere, old, "refs/pr/1")
    assert cli.main(["verify", f"{NAME}@refs/pr/1"]) == 0
    assert capsys.readouterr().out.startswith(f"{NAME}@refs/pr/1: 3 episodes")
    assert cli.main(["verify", f"{NAME}@{refs['v3.0']}"]) == 0
    assert cli.main(["columns", f"{NAME}@v3.0"]) == 0
    printed = capsys.readouterr().out
    assert f"path: {NAME}\n" in printed
    assert f"hf download {NAME} --repo-type dataset --revision {refs['v3.0']}" in printed
    assert cli.main(["verify", f"{NAME}@main", "--revision", "main"]) == 2
    assert f"expected owner/name, found {NAME}@main" in capsys.readouterr().err
    assert cli.main(["diff", f"{NAME}@v9", NAME]) == 2
    expected = f"no folder {NAME} here, and the Hub's dataset has no revision v9\n"
    assert capsys.readouterr().err.endswith(expected)


def test_two_revisions_are_compared(
    elsewhere: Hub, old: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of the videos no more is fetched than is compared."""
    put(elsewhere, old, "v2.1")
    fewer = older.write(tmp_path / "arm", arm.recording(2))
    put(elsewhere, fewer)
    a, b = f"{NAME}@v2.1", f"{NAME}@main"
    assert cli.main(["diff", a, b, "--pictures", "0"]) == 1
    assert not any(name.startswith("videos") for name in fetched(elsewhere))
    assert cli.main(["diff", a, b]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert "dropped: not in B: episode 2" in lines
    assert lines[-1].startswith(f"A {a}, B {b}: 3 and 2 episodes: 2 the same; 1 dropped")
    assert {older.video(i) for i in range(2)} <= fetched(elsewhere)
    other = arm.write(tmp_path / "other", arm.recording(2, seed=9), pictures=True)
    put(elsewhere, other, name="theirs/other")
    assert cli.main(["diff", str(old), "theirs/other"]) == 1
    assert not any(name.startswith("videos") for name in fetched(elsewhere))
    assert cli.main(["diff", str(old), "theirs/nothing"]) == 2
    assert "no folder theirs/nothing here, and no such dataset" in capsys.readouterr().err


def test_a_folder_of_this_name_comes_first(
    elsewhere: Hub, old: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(old, f"{NAME}@v9")
    assert cli.main(["verify", f"{NAME}@v9"]) == 0
    shutil.copytree(old, NAME)
    assert cli.main(["verify", NAME]) == 0
    assert cli.main(["verify", NAME, "--revision", "main"]) == 2
    assert "--revision main is of a dataset on the Hub" in capsys.readouterr().err
    assert not elsewhere.requests


COMMANDS = (["verify"], ["view", "--list"], ["view", "--save", "x.rrd"], ["columns"])


def says(
    capsys: pytest.CaptureFixture[str], expected: str, *options: str, name: str = NAME
) -> None:
    for command in COMMANDS:
        assert cli.main([*command, name, *options]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert re.search(rf"no folder {name} here, .*{expected}", line), line
        assert TOKEN not in line


def test_none_of_this_name(elsewhere: Hub, old: Path, capsys: pytest.CaptureFixture[str]) -> None:
    says(capsys, "no such dataset on the Hub.*log in")
    put(elsewhere, old)
    says(capsys, "no revision v9", "--revision", "v9")
    says(capsys, "no such dataset", name="a--b/c..d")  # no name that the Hub would give
    (Path("x")).mkdir()
    put(elsewhere, Path("x"), name="theirs/model")
    assert cli.main(["verify", "theirs/model"]) == 2
    assert "not a LeRobot dataset: theirs/model/meta/info.json" in capsys.readouterr().err


def test_a_hub_that_does_not_answer(
    elsewhere: Hub, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    elsewhere.fail["refs"] = (500, "who said {}?")
    says(capsys, "the Hub does not give the dataset: .*500")
    elsewhere.fail["refs"] = (403, "Forbidden for {}")
    says(capsys, "the Hub does not give the dataset: .*403")
    monkeypatch.setattr(constants, "ENDPOINT", "http://127.0.0.1:9")
    says(capsys, "the Hub does not give the dataset: .*[Rr]efused")


def test_offline_the_cache_is_asked(
    elsewhere: Hub, old: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    put(elsewhere, old, "v2.1")
    monkeypatch.setattr(constants, "HF_HUB_OFFLINE", True)
    says(capsys, "HF_HUB_OFFLINE is set")
    monkeypatch.setattr(constants, "HF_HUB_OFFLINE", False)
    assert cli.main(["columns", NAME]) == 0
    monkeypatch.setattr(constants, "HF_HUB_OFFLINE", True)
    elsewhere.requests.clear()
    assert cli.main(["view", NAME, "--list"]) == 0
    assert cli.main(["columns", NAME]) == 0
    capsys.readouterr()
    assert cli.main(["verify", NAME]) == 2  # the cache lacks its videos, which are not missing
    assert f"lacks 3 files of {NAME}, such as videos/" in capsys.readouterr().err
    assert not elsewhere.requests
