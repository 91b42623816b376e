"""What the README shows of `results/`: figure, table and times, between the markers "results"."""

from __future__ import annotations

from pathlib import Path

from lfr.evaluation.records import RESULTS, stage_runs

MARKER = "results"
NOT_YET = "*Nothing has been measured yet: `make repro` puts the figure and the table here.*"


def results_block(results: Path = RESULTS) -> str:
    """The block that the README should show: figure, table, and seconds of each stage."""
    table = results / "table.md"
    if not table.is_file():
        return NOT_YET
    parts = [table.read_text(encoding="utf-8").strip()]
    if (results / "learning.svg").is_file():
        parts.insert(0, f"![Success against environment steps]({results.name}/learning.svg)")
    if (results / "report.md").is_file():
        parts.append(
            "Percent of held-out episodes, some with the Wilson interval of 95 %. Identity: the "
            "source's actions carried out by the target. No generator: its skills by the target's "
            "decoder. Linear: the best linear map in G's place. Zero-shot: by G, before any "
            "learning on the target. Retarget: the source's motions of the hand, by both arms' "
            "kinematic models. Oracle: the target, had it been shown the task. The whole report, "
            f"with all revisions: [report.md]({results.name}/report.md)."
        )
    parts.append(_times(results))
    return "\n\n".join(part for part in parts if part)


def _times(results: Path) -> str:
    """One sentence: how long the stages took, beside others, by their own metrics; "" without."""
    seconds = {
        stage: [run.seconds for run in keys.values()]
        for stage, keys in stage_runs(results).items()
        if keys
    }
    if not seconds:
        return ""
    each = ", ".join(f"{name} {sum(runs):.0f} ({len(runs)})" for name, runs in seconds.items())
    return f"Seconds of each stage (runs), of which several run at a time: {each}."
