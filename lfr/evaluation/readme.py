"""What the README shows of `results/`: table and figure, between the markers "results"."""

from __future__ import annotations

from pathlib import Path

from lfr.evaluation.records import RESULTS

MARKER = "results"
NOT_YET = "*Nothing has been measured yet: `make repro` puts the figure and the table here.*"


def results_block(results: Path = RESULTS) -> str:
    """The block that the README should show."""
    table = results / "table.md"
    if not table.is_file():
        return NOT_YET
    parts = [table.read_text(encoding="utf-8").strip()]
    if (results / "learning.svg").is_file():
        parts.append(f"![Success against environment steps]({results.name}/learning.svg)")
    if (results / "report.md").is_file():
        parts.append(
            "Percent of held-out starts, sparse reward. Not learned: the mapped skills as they "
            "are. Learned: after reinforcement learning on the target. Identity: the source's "
            "actions as they are. Linear: the best linear map in the mapping's place. Retarget: "
            "the source's motions of the hand, by both arms' kinematic models. Oracle: the target, "
            "had it been shown the task. Paper: its own result, under a controller that it does "
            f"not name. [All numbers, their seeds and intervals]({results.name}/report.md)."
        )
    return "\n\n".join(parts)
