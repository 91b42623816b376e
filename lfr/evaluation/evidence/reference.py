"""SAC on Panda's Lift beside robosuite-benchmark's: return of 500 steps, curves and a sentence."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lfr.artifacts import write_whole
from lfr.errors import DataError
from lfr.evaluation.evidence.style import STYLE, look

BENCHMARK = Path("paper/robosuite-benchmark-lift-panda.csv")
THEIRS_LABEL, OURS_LABEL = "robosuite-benchmark's SAC", "SAC here"
THEIRS_COLOR = "#444444"
THEIRS_STEPS = 1e6  # that is where the benchmark reports its returns

Curves = Mapping[int, tuple[np.ndarray, np.ndarray]]
"""seed -> environment steps and mean returns, (P,) each."""


@dataclass(frozen=True)
class Reference:
    """Both programs' curves of one task, under the same controller and dense reward."""

    ours: Curves
    theirs: Curves

    @property
    def ends(self) -> tuple[float, float]:
        """Environment steps as far as every seed of ours goes, and every seed of theirs."""
        return _end(self.ours), min(_end(self.theirs), THEIRS_STEPS)


def _end(curves: Curves) -> float:
    return min(float(steps[-1]) for steps, _ in curves.values())


def read_reference(ours: Path, theirs: Path = BENCHMARK) -> Reference | None:
    """Both files; None where either is missing.

    Raises:
        DataError: a file lacks a column, or holds no curve.
    """
    if not (ours.is_file() and theirs.is_file()):
        return None
    return Reference(_read(ours), _read(theirs))


def _read(path: Path) -> Curves:
    found: dict[int, list[tuple[float, float]]] = {}
    with path.open(newline="", encoding="utf-8") as stream:
        try:
            for row in csv.DictReader(stream):
                point = float(row["env_steps"]), float(row["mean_return"])
                found.setdefault(int(row["seed"]), []).append(point)
        except KeyError as column:
            raise DataError("the file lacks a column", file=path, expected=column) from None
    if not found:
        raise DataError("the file holds no curve", file=path, expected="a row or more")
    columns = {seed: np.array(sorted(points)).T for seed, points in found.items()}
    return {seed: (steps, returns) for seed, (steps, returns) in columns.items()}


def returns_at(curves: Curves, steps: float) -> np.ndarray:
    """Every seed's return after so many environment steps, linearly between its points: (N,)."""
    return np.array([np.interp(steps, *curve) for curve in curves.values()])


def reference_sentence(found: Reference) -> str:
    """What both return at the end of ours, and theirs at the end of theirs."""
    end, last = found.ends
    ours, theirs = returns_at(found.ours, end), returns_at(found.theirs, end)
    if ours.min() > theirs.max():
        place = "every seed of ours is above every one of theirs"
    elif ours.max() < theirs.min():
        place = "every seed of ours is below every one of theirs"
    else:
        place = "the seeds of both overlap"
    return (
        f"After {_said(end)} environment steps of Lift on Panda with the dense reward, SAC "
        f"here returns {_spread(ours)} in 500 steps and robosuite-benchmark's "
        f"{_spread(theirs)}: {place}. After {_said(last)} steps "
        f"theirs returns {_spread(returns_at(found.theirs, last))}."
    )


def _said(steps: float) -> str:
    return f"{steps / 1e6:g} million" if steps >= 1e6 else f"{steps / 1000:.0f} thousand"


def _spread(returns: np.ndarray) -> str:
    """``104.2 (81.0 to 130.5, 5 seeds)``"""
    return (
        f"{returns.mean():.1f} ({returns.min():.1f} to {returns.max():.1f}, {len(returns)} seeds)"
    )


def reference_figure(path: Path, found: Reference) -> None:
    """Return of 500 steps against environment steps, as SVG: as far as ours goes, and all of it.

    Thin lines are seeds, the thick line is their mean.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        drawn = Figure(figsize=(7.6, 3.1), layout="constrained")
        panels = drawn.subplots(1, 2)
        parts = ((found.theirs, THEIRS_COLOR, "-", THEIRS_LABEL),
                 (found.ours, look("sac").color, look("sac").line, OURS_LABEL))  # fmt: skip
        for panel, end in zip(panels, found.ends, strict=True):
            for curves, color, line, label in parts:
                for steps, returns in curves.values():
                    panel.plot(steps / 1000, returns, color=color, linewidth=0.6, alpha=0.5)
                axis = _axis(curves)
                mean = np.mean([np.interp(axis, *curve) for curve in curves.values()], axis=0)
                panel.plot(axis / 1000, mean, color=color, linestyle=line, linewidth=2, label=label)
            inside = [
                returns[steps <= end * 1.01].max(initial=0.0)
                for curves in (found.ours, found.theirs)
                for steps, returns in curves.values()
            ]
            panel.set_xlim(0, end / 1000)
            panel.set_ylim(0, 1.08 * max(*inside, 1.0))
            panel.grid(axis="y", color="#e5e5e5", linewidth=0.6)
            panel.set_title(f"the first {_said(end)}" if end < found.ends[1]
                            else "all of it", loc="left")  # fmt: skip
        drawn.supxlabel("environment steps, thousands", fontsize=9)
        drawn.supylabel("return of 500 steps", fontsize=9)
        handles, labels = panels[0].get_legend_handles_labels()
        drawn.legend(handles, labels, loc="outside upper center", ncols=2, handlelength=3.2)
        with write_whole(path) as partial:
            drawn.savefig(partial, format="svg", metadata={"Date": None})


def _axis(curves: Curves) -> np.ndarray:
    """The points of all seeds where each of them has begun and none has ended."""
    begin = max(steps[0] for steps, _ in curves.values())
    points = np.unique(np.concatenate([steps for steps, _ in curves.values()]))
    return points[(points >= begin) & (points <= _end(curves))]
