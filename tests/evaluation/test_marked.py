"""What stands between markers: replaced whole, and nothing else touched."""

from pathlib import Path

import pytest

from lfr.errors import DataError
from lfr.evaluation.marked import put, shown

BEGIN, END = "<!-- results -->", "<!-- /results -->"
TABLE = "| transfer | success |\n|---|---|\n| s1-panda-lift | 0.5 |"


@pytest.fixture
def readme(tmp_path: Path) -> Path:
    path = tmp_path / "README.md"
    path.write_text(f"# Title\n\n{BEGIN}\nold\n{END}\n\nThe rest.\n")
    return path


def test_block_is_replaced_and_the_rest_stays(readme: Path) -> None:
    put(readme, "results", TABLE)
    assert readme.read_text() == f"# Title\n\n{BEGIN}\n{TABLE}\n{END}\n\nThe rest.\n"
    assert shown(readme, "results") == TABLE


def test_block_that_is_current_leaves_the_file_alone(readme: Path) -> None:
    put(readme, "results", TABLE)
    before = readme.stat()
    put(readme, "results", TABLE)
    assert readme.stat().st_ino == before.st_ino


@pytest.mark.parametrize("text", ["no markers", BEGIN, f"{END}{BEGIN}", f"{BEGIN}{BEGIN}{END}"])
def test_missing_or_doubled_markers_are_named(tmp_path: Path, text: str) -> None:
    path = tmp_path / "README.md"
    path.write_text(text)
    with pytest.raises(DataError, match=r"README\.md"):
        put(path, "results", TABLE)
    assert path.read_text() == text
