"""The figures of docs/evidence.md, from the tables of all runs and of their curves."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from statistics import fmean
from typing import Any

import numpy as np

from lfr.artifacts import write_whole
from lfr.evaluation.figures import COLORS, STYLE
from studies.evidence.evidence_params import OURS
from studies.evidence.runs import CurvePoint, Run
from studies.evidence.tables import (
    NAMES,
    PAPER,
    PAPERS,
    chosen,
    matrix_arms,
    matrix_cell,
    task_and_target,
)

LEARNERS = (("lfr", OURS), ("retarget", ""), ("ap", ""), ("sac", ""), ("spirl", ""))


def learning_figure(path: Path, runs: Sequence[Run], curves: Sequence[CurvePoint]) -> None:
    """Figures 3 and 4: success against environment steps on the paper's transfers, as SVG.

    Lines are means over seeds on a few learning starts; dots with bars are held-out results with
    their intervals, before and after; the broken line is the paper's own final figure.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        figure = Figure(figsize=(10.5, 2.9), layout="constrained")
        axes = figure.subplots(1, len(PAPERS), sharey=True)
        for panel, transfer in zip(axes, PAPERS, strict=True):
            known = [run for run in runs if run.transfer == transfer]
            if not known:
                continue
            panel.set_title(task_and_target(known[0]), loc="left")
            panel.grid(axis="y", color="#e5e5e5", linewidth=0.6)
            panel.set_axisbelow(True)
            panel.set_ylim(-0.03, 1.03)
            panel.set_yticks([0, 0.25, 0.5, 0.75, 1], ["0", "", "50", "", "100 %"])
            paper = PAPER[known[0].task, known[0].target]["lfr"] / 100
            panel.axhline(paper, color="#555555", linewidth=0.8, linestyle=(0, (4, 3)))
            for (method, option), color in zip(LEARNERS, COLORS, strict=True):
                _method(panel, runs, curves, transfer, method, option, color)
        figure.supxlabel("environment steps, thousands", fontsize=9)
        figure.supylabel("success", fontsize=9)
        ran = {run.method for run in runs}
        handles = [axes[0].plot([], [], color=color, label=NAMES[method])[0]
                   for (method, _), color in zip(LEARNERS, COLORS, strict=True)
                   if method in ran]  # fmt: skip
        handles += axes[0].plot([], [], color="#555555", linewidth=0.8, linestyle=(0, (4, 3)),
                                label="the paper's LfR")  # fmt: skip
        figure.legend(handles=handles, loc="outside upper right", ncols=len(handles), frameon=False)
        _save(figure, path)


def _method(
    panel: Any, runs: Sequence[Run], curves: Sequence[CurvePoint], transfer: str, method: str,
    option: str, color: str,
) -> None:  # fmt: skip
    wanted = (transfer, method, option, "sparse", 50)
    points = [one for one in curves if one.key[:5] == wanted]
    if points:
        # A run's evaluations come a few steps after every round number, so they are put there.
        points.sort(key=lambda one: round(one.env_steps / 5000))
        at = [
            (round_steps * 5, fmean(one.success for one in group))
            for round_steps, group in groupby(points, key=lambda one: round(one.env_steps / 5000))
        ]
        panel.plot(*zip(*at, strict=True), color=color, linewidth=1.2)
    for learned in (False, True):
        found = chosen(runs, transfer, method, learned=learned)
        if found.runs:
            mean, low, high = found.interval
            panel.errorbar(
                fmean(run.env_steps for run in found.runs) / 1000, mean,
                yerr=[[mean - low], [high - mean]], color=color, marker="o", markersize=4.5,
                markerfacecolor=color if learned else "white", capsize=2, linewidth=1,
                clip_on=False, zorder=3,
            )  # fmt: skip


def matrix_figure(path: Path, runs: Sequence[Run]) -> None:
    """Who teaches whom, as SVG: success before learning, beside what retargeting has."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    arms = matrix_arms(runs)
    panels = (("lfr", "LfR, before learning"), ("retarget", "retarget"), ("linear", "linear"))
    with rc_context({**STYLE, "axes.spines.left": False, "axes.spines.bottom": False}):
        figure = Figure(figsize=(11.0, 4.0), layout="constrained")
        axes = figure.subplots(1, len(panels), sharey=True)
        for panel, (method, title) in zip(axes, panels, strict=True):
            rates = np.full((len(arms), len(arms)), np.nan)
            for y, source in enumerate(arms):
                for x, target in enumerate(arms):
                    cell = matrix_cell(runs, source, target, method)
                    if cell.runs:
                        rates[y, x] = cell.interval.mean
                        color = "white" if rates[y, x] > 0.6 else "#333333"
                        text = f"{100 * rates[y, x]:.0f}"
                        panel.text(x, y, text, ha="center", va="center", color=color)
            panel.imshow(rates, cmap="YlGnBu", vmin=0.0, vmax=1.0)
            names = [NAMES[arm] for arm in arms]
            panel.set_xticks(range(len(arms)), names, rotation=40, ha="right")
            panel.set_yticks(range(len(arms)), names)
            panel.tick_params(length=0)
            panel.set_title(title, loc="left")
            panel.set_xlabel("target")
        axes[0].set_ylabel("source")
        _save(figure, path)


def _save(figure: Any, path: Path) -> None:
    with write_whole(path) as partial:
        figure.savefig(partial, format="svg", metadata={"Date": None})
