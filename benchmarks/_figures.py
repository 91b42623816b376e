"""How a figure is measured, written and printed: two sides in one run, one after the other.

`results/benchmarks/<name>.json` holds one row per figure, the versions and the machine. A helper of
the scripts beside it, hence its name: `make bench` runs `benchmarks/[a-z]*.py`.
"""

from __future__ import annotations

import os
import platform
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from lfr.artifacts import provenance, write_json

FOLDER = Path("results/benchmarks")

Measurement = Callable[[], float]
"""Measures one side once."""


@dataclass(frozen=True)
class Figure:
    """One row of a file of results.

    Attributes:
        name: what was compared, e.g. `stock/panda-lift`.
        unit: of the two medians.
        ratio: ours to theirs, or theirs to ours where less is better: more is better always.
        goal: what the ratio is to reach; with `at_most`, what it must not exceed; None for a figure
            that is there to be compared with another machine's.
        spread: smallest and largest ratio of a single repeat.
        ours, theirs: medians over the repeats.
    """

    name: str
    unit: str
    ratio: float
    goal: float | None
    spread: tuple[float, float]
    ours: float
    theirs: float
    at_most: bool = False

    @property
    def reached(self) -> bool | None:
        """None without a goal."""
        if self.goal is None:
            return None
        return self.ratio <= self.goal if self.at_most else self.ratio >= self.goal


def compare(
    name: str, unit: str, goal: float, ours: Measurement, theirs: Measurement, repeats: int
) -> Figure:
    """Measure rates (more is better) on both sides alternately, after one round to warm up."""
    ours(), theirs()
    pairs = []
    for repeat in range(repeats):
        if repeat % 2:  # neither side always comes first
            second = theirs()
            pairs.append((ours(), second))
        else:
            pairs.append((ours(), theirs()))
    return against(name, unit, goal, pairs)


def against(
    name: str, unit: str, goal: float | None, pairs: Sequence[tuple[float, float]]
) -> Figure:
    """The figure of rates (ours, theirs) that were measured pair by pair."""
    ratios = sorted(a / b for a, b in pairs)
    return Figure(
        name=name,
        unit=unit,
        ratio=statistics.median(ratios),
        goal=goal,
        spread=(ratios[0], ratios[-1]),
        ours=statistics.median(a for a, _ in pairs),
        theirs=statistics.median(b for _, b in pairs),
    )


def within(name: str, unit: str, limit: float, amounts: Sequence[float]) -> Figure:
    """The figure of amounts (less is better), as parts of the most that each may be."""
    parts = sorted(amount / limit for amount in amounts)
    return Figure(
        name=name,
        unit=unit,
        ratio=statistics.median(parts),
        goal=1.0,
        spread=(parts[0], parts[-1]),
        ours=statistics.median(amounts),
        theirs=limit,
        at_most=True,
    )


def show(figure: Figure) -> None:
    """One line on standard output."""
    word, sign = ("reached" if figure.reached else "MISSED"), ("<=" if figure.at_most else ">=")
    goal = "" if figure.goal is None else f"goal {sign} {figure.goal:g} {word}"
    print(
        f"{figure.name:32s} {figure.ratio:8.2f} ({figure.spread[0]:.2f} to {figure.spread[1]:.2f})"
        f"  {goal}  {figure.ours:.4g} against {figure.theirs:.4g} "
        f"{figure.unit}",
        flush=True,
    )


def write(
    name: str,
    figures: list[Figure],
    folder: Path = FOLDER,
    more: Mapping[str, object] | None = None,
    **machine: str,
) -> Path:
    """Write `<folder>/<name>.json`; returns its path.

    Args:
        more: what is to be known besides the figures.
        machine: what else is to be known of the one that measured.
    """
    path = folder / f"{name}.json"
    rows = [asdict(figure) | {"reached": figure.reached} for figure in figures]
    described = {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load_average": os.getloadavg()[0],
        **machine,
    }
    content = {"figures": rows, **(more or {}), "machine": described, "made_with": provenance()}
    write_json(path, content)
    return path


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names = (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor())
