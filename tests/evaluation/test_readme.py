"""The README's block of results: replaced whole, and nothing else touched."""

from pathlib import Path

import pytest

from lfr.artifacts import write_json
from lfr.errors import DataError
from lfr.evaluation.readme import BEGIN, END, NOT_YET, results_block, shown_block, update_readme

TABLE = "| transfer | success |\n|---|---|\n| s1-panda-lift | 0.5 |"


@pytest.fixture
def readme(tmp_path: Path) -> Path:
    path = tmp_path / "README.md"
    path.write_text(f"# Title\n\n{BEGIN}\nold\n{END}\n\nThe rest.\n")
    return path


def test_block_is_replaced_and_the_rest_stays(readme: Path) -> None:
    update_readme(readme, TABLE)
    assert readme.read_text() == f"# Title\n\n{BEGIN}\n{TABLE}\n{END}\n\nThe rest.\n"
    assert shown_block(readme) == TABLE


def test_block_that_is_current_leaves_the_file_alone(readme: Path) -> None:
    update_readme(readme, TABLE)
    before = readme.stat()
    update_readme(readme, TABLE)
    assert readme.stat().st_ino == before.st_ino


@pytest.mark.parametrize("text", ["no markers", BEGIN, f"{END}{BEGIN}", f"{BEGIN}{BEGIN}{END}"])
def test_missing_or_doubled_markers_are_named(tmp_path: Path, text: str) -> None:
    path = tmp_path / "README.md"
    path.write_text(text)
    with pytest.raises(DataError, match=r"README\.md"):
        update_readme(path, TABLE)
    assert path.read_text() == text


def test_block_is_made_of_what_results_hold(tmp_path: Path) -> None:
    results = tmp_path / "results"
    assert results_block(results) == NOT_YET
    results.mkdir()
    (results / "table.md").write_text(TABLE + "\n")
    assert results_block(results) == TABLE
    (results / "learning.svg").write_text("<svg/>")
    write_json(results / "record" / "panda-lift.json", {"seconds": 40.4})
    write_json(results / "record" / "sawyer-lift.json", {"seconds": 50.0})
    write_json(results / "transfer" / "s1-panda-lift-lfr.json", {"seconds": 120.0})
    block = results_block(results)
    assert "](results/learning.svg)" in block
    assert TABLE in block
    assert "record 90 (2)" in block
    assert "transfer 120 (1)" in block
