"""The README's block of results."""

from pathlib import Path

from lfr.evaluation.readme import NOT_YET, results_block

TABLE = "| transfer | success |\n|---|---|\n| s1-panda-lift | 0.5 |"


def test_block_is_made_of_what_results_hold(tmp_path: Path) -> None:
    results = tmp_path / "results"
    assert results_block(results) == NOT_YET
    results.mkdir()
    (results / "table.md").write_text(TABLE + "\n")
    assert results_block(results) == TABLE
    (results / "learning.svg").write_text("<svg/>")
    block = results_block(results)
    assert "](results/learning.svg)" in block
    assert TABLE in block
