"""What the README shows of `results/`: figure, table and times, between two markers."""

from __future__ import annotations

from pathlib import Path

from lfr.artifacts import read_json, write_whole
from lfr.errors import DataError

BEGIN, END = "<!-- results -->", "<!-- /results -->"
NOT_YET = "*Nothing has been measured yet: `make repro` puts the figure and the table here.*"
STAGES = ("record", "pack", "skills", "mapping", "transfer", "evaluate")


def results_block(results: Path) -> str:
    """The block that the README should show: `learning.svg`, `table.md`, seconds of each stage."""
    table = results / "table.md"
    if not table.is_file():
        return NOT_YET
    figure = results / "learning.svg"
    picture = f"![Success while learning]({results.name}/{figure.name})" if figure.is_file() else ""
    parts = (picture, table.read_text(encoding="utf-8").strip(), stage_seconds(results))
    return "\n\n".join(part for part in parts if part)


def stage_seconds(results: Path) -> str:
    """One sentence: how long the runs of each stage took, by their own metrics; "" without any."""
    times = []
    for stage in STAGES:
        metrics = [read_json(file) for file in sorted((results / stage).glob("*.json"))]
        seconds = [one["seconds"] for one in metrics if "seconds" in one]
        if seconds:
            times.append((stage, len(seconds), sum(seconds)))
    if not times:
        return ""
    each = ", ".join(f"{stage} {total:.0f} s ({runs}x)" for stage, runs, total in times)
    minutes = sum(total for _, _, total in times) / 60
    return f"That run's wall-clock by stage: {each}; {minutes:.0f} minutes together."


def update_readme(readme: Path, block: str) -> None:
    """Put ``block`` (Markdown) between the README's markers.

    Raises:
        DataError: the markers are not there, or not once each and in order.
    """
    before, shown, after = _split(readme)
    if shown == block:
        return
    with write_whole(readme) as partial:
        partial.write_text(f"{before}{BEGIN}\n{block}\n{END}{after}", encoding="utf-8")


def shown_block(readme: Path) -> str:
    """What stands between the README's markers now.

    Raises:
        DataError: as `update_readme`.
    """
    return _split(readme)[1]


def _split(readme: Path) -> tuple[str, str, str]:
    text = readme.read_text(encoding="utf-8")
    found = [text.count(marker) for marker in (BEGIN, END)]
    if found != [1, 1] or text.index(END) < text.index(BEGIN):
        raise DataError(
            "the markers of the results are not there once each",
            file=readme, found=found, expected=f"one {BEGIN} and, after it, one {END}",
        )  # fmt: skip
    before, rest = text.split(BEGIN)
    shown, after = rest.split(END)
    return before, shown.strip(), after
