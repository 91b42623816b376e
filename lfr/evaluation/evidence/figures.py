"""Learning curves: the paper's Figures 3 and 4, and the same for ablations and questions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfr.artifacts import write_whole
from lfr.evaluation.evidence.aggregate import bootstrap, interquartile_mean, over_seeds
from lfr.evaluation.evidence.curves import side_by_side
from lfr.evaluation.evidence.names import METHODS, in_order, method_label
from lfr.evaluation.evidence.pairs import no_learning
from lfr.evaluation.evidence.published import ABLATIONS, BASELINES, SCENARIO_1, SCENARIO_2, TASKS
from lfr.evaluation.evidence.records import Evidence, SeedRun, counts
from lfr.evaluation.evidence.style import PERCENT, STYLE, look
from lfr.evaluation.evidence.summary import OURS

Panel = Any  # matplotlib's Axes


@dataclass(frozen=True)
class CurveFigure:
    """What a figure shows: a column for each transfer, a row for each reward.

    Attributes:
        methods: those drawn, where they have a run; LfR last, so on top.
        links: zero-shot links drawn as a level, since they take no steps.
    """

    transfers: tuple[str, ...]
    methods: tuple[str, ...]
    links: tuple[str, ...] = ()


FIGURES = {
    "figure3": CurveFigure(SCENARIO_1, (*BASELINES, OURS), ("identity",)),
    "figure4": CurveFigure(SCENARIO_2, (*BASELINES, OURS), ("identity",)),
    "ablations": CurveFigure(SCENARIO_2, (*ABLATIONS, OURS)),
    "questions": CurveFigure(
        SCENARIO_2, ("shared_vae", "spirl", "spirl_no_prior", "wrong_task", OURS)
    ),
}


def curve_figure(path: Path, figure: CurveFigure, evidence: Evidence) -> None:
    """Success against environment steps, as SVG.

    Thin lines are single seeds, on a few starts; the thick line is their interquartile mean, the
    band its bootstrap interval over seeds. The marks right of a panel are the final held-out rates'
    interquartile means with their bootstrap intervals; a method that learns without the target
    arm is a horizontal line at its own.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    rewards = _rewards(figure, evidence)
    named = len(evidence.rewards()) > 1
    present = set(evidence.methods(figure.transfers))
    methods = [method for method in figure.methods if method in present]
    across, down = len(figure.transfers), len(rewards)
    with rc_context(STYLE):
        drawn = Figure(figsize=(3.6 * min(across, 2) + 1.3 * max(across - 2, 0) + 0.4,
                                2.5 * down + 0.8), layout="constrained")  # fmt: skip
        panels = drawn.subplots(down, across, sharey=True, squeeze=False)
        for row, reward in enumerate(rewards):
            for column, transfer in enumerate(figure.transfers):
                panel = panels[row][column]
                title = TASKS.get(transfer, transfer)
                panel.set_title(f"{title}, {reward}" if named else title, loc="left")
                _frame(panel)
                _draw(panel, evidence, transfer, reward, methods)
                _levels(panel, evidence, transfer, figure.links)
        drawn.supxlabel("environment steps, thousands", fontsize=9)
        drawn.supylabel("success", fontsize=9)
        handles = [_key(panels[0][0], method) for method in in_order(methods, METHODS)]
        levels = {line.get_label(): line for panel in panels.flat for line in panel.lines
                  if line.get_label() in map(no_learning, figure.links)}  # fmt: skip
        handles += levels.values()
        if handles:
            drawn.legend(handles=handles, loc="outside upper center", ncols=_columns(handles),
                         handlelength=3.2)  # fmt: skip
        with write_whole(path) as partial:
            drawn.savefig(partial, format="svg", metadata={"Date": None})


def _columns(handles: Sequence[Any]) -> int:
    """Of a legend: one row where its labels fit over two panels, some hundred letters."""
    letters = sum(len(handle.get_label()) + 9 for handle in handles)  # and each its line
    return len(handles) if letters <= 100 else 3


def others(figure: CurveFigure, evidence: Evidence) -> list[SeedRun]:
    """The figure's runs that are not LfR's: without them it compares nothing."""
    return [
        run for run in evidence.runs
        if run.transfer in figure.transfers and run.method in figure.methods and run.method != OURS
    ]  # fmt: skip


def _rewards(figure: CurveFigure, evidence: Evidence) -> list[str]:
    """Those under which LfR has company; all of them where it has none yet."""
    company = {run.reward for run in others(figure, evidence)}
    return [reward for reward in evidence.rewards() if reward in company] or evidence.rewards()


def _levels(panel: Panel, evidence: Evidence, transfer: str, links: Sequence[str]) -> None:
    found = evidence.links.get(transfer)
    for link in links:
        if found and link in found.links:
            level = bootstrap([found.links[link]]).value
            panel.axhline(level, color="#777777", linewidth=1.1, zorder=2, label=no_learning(link))


def _frame(panel: Panel) -> None:
    panel.grid(axis="y", color="#e5e5e5", linewidth=0.6)
    panel.set_axisbelow(True)
    panel.set_ylim(-0.03, 1.03)
    panel.set_yticks(*PERCENT)


def _draw(
    panel: Panel, evidence: Evidence, transfer: str, reward: str, methods: Sequence[str]
) -> None:
    runs = {method: evidence.of(transfer, method, reward) for method in methods}
    there = {method: found for method, found in runs.items() if found}
    end = max((run.env_steps or 0 for found in there.values() for run in found), default=0) / 1000
    if not there:
        panel.text(0.5, 0.5, "no run yet", transform=panel.transAxes, ha="center", color="#777777")
        panel.set_xticks([])
        return
    end = end or 1.0  # nothing but methods without steps
    for place, (method, found) in enumerate(there.items()):
        _curves(panel, method, found, end)
        _final(panel, method, found, end * (1.05 + 0.05 * place))
    panel.set_xlim(0, end * (1.05 + 0.05 * len(there)))
    panel.axvline(end * 1.015, color="#bbbbbb", linewidth=0.6)
    panel.set_xticks([tick for tick in panel.get_xticks() if tick <= end])


def _curves(panel: Panel, method: str, runs: Sequence[SeedRun], end: float) -> None:
    style, top = look(method), 4.0 if method == OURS else 3.0
    curves = [run.curve for run in runs if run.curve]
    if not curves:
        rate = bootstrap([counts(runs)]).value
        panel.plot([0, end], [rate, rate], color=style.color, linestyle=style.line,
                   linewidth=1.4, zorder=top)  # fmt: skip
        return
    for curve in curves:
        steps = [step / 1000 for step in curve.env_steps]
        panel.plot(steps, curve.success, color=style.color, linewidth=0.5, alpha=0.45,
                   zorder=top - 1)  # fmt: skip
    axis, rates = side_by_side(curves)
    middle, low, high = over_seeds(rates, interquartile_mean)
    panel.fill_between(axis / 1000, low, high, color=style.color, alpha=0.15, linewidth=0,
                       zorder=top - 2)  # fmt: skip
    panel.plot(axis / 1000, middle, color=style.color, linestyle=style.line, linewidth=2.0,
               zorder=top)  # fmt: skip


def _final(panel: Panel, method: str, runs: Sequence[SeedRun], x: float) -> None:
    style, found = look(method), bootstrap([counts(runs)])
    panel.errorbar(
        x, found.value, yerr=[[found.value - found.low], [found.high - found.value]],
        color=style.color, marker=style.marker, markersize=4.5, capsize=2, linewidth=1,
        clip_on=False, zorder=5,
    )  # fmt: skip


def _key(panel: Panel, method: str) -> Any:
    style = look(method)
    (line,) = panel.plot([], [], color=style.color, linestyle=style.line, marker=style.marker,
                         markersize=4.5, linewidth=2.0, label=method_label(method))  # fmt: skip
    return line
