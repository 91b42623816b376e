"""The pipeline as a picture: `python -m pipeline._dag` draws it anew wherever a document shows it.

What DVC draws has a box for every arm, task and transfer; here each stage is one, with how many
there are of it.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

from lfr.artifacts import write_whole
from lfr.errors import LfrError
from lfr.program import run_program

BEGIN, END = "<!-- dag -->", "<!-- /dag -->"
SHOWN_IN = ("docs/dvc.md",)
NODE = re.compile(r'^\s*(node\d+)\["([^"]+)"\]$', re.MULTILINE)
EDGE = re.compile(r"^\s*(node\d+)-->(node\d+)$", re.MULTILINE)


def dvc_dag(project: Path = Path()) -> str:
    """`dvc dag --mermaid` of a project.

    Raises:
        LfrError: DVC cannot draw it.
    """
    command = [sys.executable, "-m", "dvc", "dag", "--mermaid"]
    done = subprocess.run(command, cwd=project, capture_output=True, text=True, check=False)
    if done.returncode:
        raise LfrError(f"dvc dag: {done.stderr.strip().splitlines()[-1]}")
    return done.stdout


def stages_before(mermaid: str) -> dict[str, set[str]]:
    """Of each stage in DVC's graph those that it depends on directly."""
    stage_of = dict(NODE.findall(mermaid))
    before: dict[str, set[str]] = {stage: set() for stage in stage_of.values()}
    for a, b in EDGE.findall(mermaid):
        before[stage_of[b]].add(stage_of[a])
    return before


def collapsed(mermaid: str) -> str:
    """DVC's graph with one box for each stage, as Markdown.

    The boxes stand in the order of the data: after all that they depend on.
    """
    runs = stages_before(mermaid)
    counts = Counter(map(_name, runs))
    before: dict[str, set[str]] = {stage: set() for stage in counts}
    for run, earlier in runs.items():
        before[_name(run)] |= {_name(one) for one in earlier} - {_name(run)}
    order: list[str] = []
    while len(order) < len(before):
        order.append(min(s for s in before if s not in order and before[s] <= set(order)))
    boxes = [
        f'    {stage}["{stage}{f" × {counts[stage]}" if counts[stage] > 1 else ""}"]'
        for stage in order
    ]
    lines = [f"    {a} --> {b}" for a in order for b in order if a in before[b]]
    return "\n".join(["```mermaid", "flowchart LR", *boxes, *lines, "```"])


def _name(run: str) -> str:
    return run.partition("@")[0]


def shown(text: str) -> str | None:
    """The picture between a document's markers, None where there are none."""
    found = re.search(f"{BEGIN}\n(.*?)\n{END}", text, re.DOTALL)
    return found.group(1) if found else None


def main(project: Path = Path()) -> None:
    """Put the picture into each document that has its markers."""
    picture = collapsed(dvc_dag(project))
    for name in SHOWN_IN:
        document = project / name
        if not document.is_file():
            continue
        text = document.read_text(encoding="utf-8")
        old = shown(text)
        if old is not None and old != picture:
            new = text.replace(f"{BEGIN}\n{old}\n{END}", f"{BEGIN}\n{picture}\n{END}")
            with write_whole(document) as partial:
                partial.write_text(new, encoding="utf-8")
            print(document)


if __name__ == "__main__":
    sys.exit(run_program(main))
