"""A report as a short summary in Markdown, for a pull request."""

from __future__ import annotations

from pathlib import Path

from lfr.artifacts import write_whole
from lfr.curation.report.words import by_kind, cell, code, episodes_of, ranges
from lfr.curation.verify import Report

MOST = 50  # findings in the details: a comment on GitHub holds 65,536 letters


def write_markdown(report: Report, path: Path) -> None:
    """Write the summary, whole."""
    with write_whole(path) as partial:
        partial.write_text(summary(report), encoding="utf-8")


def summary(report: Report) -> str:
    """The last line, a table of the kinds with the first finding of each, and the rest folded."""
    lines = [f"**lfr verify** {code(report)}", ""]
    if not report.findings:
        return "\n".join(lines)
    lines += ["| kind | | findings | episodes | the first |", "|---|---|---|---|---|"]
    for kind, findings in by_kind(report.findings).items():
        episodes = len(episodes_of(findings)) or "-"
        lines.append(f"| {cell(kind)} | {findings[0].severity} | {len(findings)} | {episodes} | "
                     f"{cell(findings[0])} |")  # fmt: skip
    lines += ["", "<details><summary>All findings</summary>", ""]
    lines += [f"- {code(finding)}" for finding in report.findings[:MOST]]
    if len(report.findings) > MOST:
        lines.append(f"- and {len(report.findings) - MOST} more")
    worst = [score.episode for score in report.scores if score.score < 1]
    if worst:
        lines += ["", f"Episodes with findings: {ranges(worst)}"]
    return "\n".join([*lines, "", "</details>", ""])
