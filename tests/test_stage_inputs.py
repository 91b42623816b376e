"""A stage that DVC runs refuses datasets of which DVC would not see that they have changed."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from lfr.artifacts import file_hash
from lfr.errors import DataError
from pipeline._stage import rows_of


@pytest.fixture
def crane(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A dataset outside of the project, whose folder is empty and the current one."""
    folder = tmp_path / "disk/crane"
    for part in ("meta", "data/chunk-000"):
        (folder / part).mkdir(parents=True)
        (folder / part / "rows").write_text(part)
    (tmp_path / "project/data").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "project")
    monkeypatch.setenv("DVC_STAGE", "external-skills@crane")
    return folder


def linked(place: str, to: Path) -> None:
    Path(place).parent.mkdir(parents=True, exist_ok=True)
    Path(place).symlink_to(to)


def test_what_lies_there_is_taken(crane: Path) -> None:
    shutil.copytree(crane, "data/external/crane")
    (Path("data/external/crane/data/chunk-000/more")).symlink_to(crane / "meta/rows")  # a file
    named = Path("data/external/crane")
    assert rows_of([named]) == [named / "meta", named / "data"]


def test_the_folder_of_all_may_be_a_link(crane: Path) -> None:
    linked("data/external", crane.parent)
    assert rows_of([Path("data/external/crane")])


@pytest.mark.parametrize("place", ["crane", "crane/data", "crane/data/chunk-000"])
def test_a_link_below_it_may_not(crane: Path, place: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if place != "crane":
        shutil.copytree(crane, "data/external/crane")
        shutil.rmtree(Path("data/external") / place)
    linked(f"data/external/{place}", crane.parent / place)
    with pytest.raises(DataError, match=rf"does not see.*data/external/{place}, found a link to"):
        rows_of([Path("data/external/crane")])
    monkeypatch.delenv("DVC_STAGE")
    assert rows_of([Path("data/external/crane")])  # by hand, everything runs


def test_nor_may_it_lie_elsewhere(crane: Path) -> None:
    for path in (crane, Path("data/external/../../../disk/crane"), Path("mine")):
        with pytest.raises(DataError, match="put it into data/external"):
            rows_of([path])


def test_work_that_was_begun_knows_what_is_behind_a_link(crane: Path) -> None:
    (crane / "data/chunk-001").symlink_to(crane.parent / "more")
    (crane.parent / "more").mkdir()
    (crane.parent / "more/rows").write_text("one")
    before = file_hash(crane / "data")
    (crane.parent / "more/rows").write_text("two")
    assert file_hash(crane / "data") != before
