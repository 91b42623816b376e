"""The headline: what every method reaches on every transfer, each seed a dot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lfr.artifacts import write_whole
from lfr.evaluation.evidence.aggregate import bootstrap
from lfr.evaluation.evidence.names import method_label
from lfr.evaluation.evidence.published import PUBLISHED, TASKS
from lfr.evaluation.evidence.records import Evidence, counts
from lfr.evaluation.evidence.style import PERCENT, STYLE, look

WIDTH = 9.0  # inches; 864 px where an SVG's point is 4/3 px
LINKS = {
    "mapped": "LfR's start, no learning",
    "identity": "identity, no learning",
    "shared_vae": "shared VAE, no learning",
    "oracle": "oracle, no learning",
}
"""Zero-shot links shown, and what they are called here."""
LINK_COLOR = "#666666"


def headline_figure(path: Path, evidence: Evidence) -> None:
    """Final held-out success, as SVG: a column per transfer, a row per method.

    Dots are seeds, filled for the first reward and hollow for the second; a bar spans the bootstrap
    interval of the interquartile mean; a grey stroke is the paper's figure. The rows below the line
    are zero-shot links, which learn nothing.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    methods = evidence.methods(TASKS)
    present = {link for found in evidence.links.values() for link in found.links}
    links = [link for link in LINKS if link in present]
    rows = max(len(methods) + len(links), 1)
    with rc_context(STYLE):
        drawn = Figure(figsize=(WIDTH, 0.27 * rows + 1.15), layout="constrained")
        panels = drawn.subplots(1, len(TASKS), sharey=True)
        for panel, (transfer, title) in zip(panels, TASKS.items(), strict=True):
            panel.set_title(title, loc="left")
            panel.set_xlim(-0.04, 1.04)
            panel.set_xticks(*PERCENT)
            panel.grid(axis="x", color="#e5e5e5", linewidth=0.6)
            panel.set_axisbelow(True)
            panel.tick_params(axis="y", length=0)
            for row, method in enumerate(methods):
                _row(panel, evidence, transfer, method, row)
            if methods and links:
                panel.axhline(len(methods) - 0.5, color="#999999", linewidth=0.6)
            for row, link in enumerate(links, start=len(methods)):
                _link_row(panel, evidence, transfer, link, row)
        labels = [*map(method_label, methods), *(LINKS[link] for link in links)]
        panels[0].set_yticks(range(len(labels)), labels)
        panels[0].set_ylim(rows - 0.5, -0.5)
        if labels:
            keys = _keys(panels[0], evidence, bool(methods), bool(links))
            drawn.legend(handles=keys, loc="outside lower center", ncols=len(keys))
        with write_whole(path) as partial:
            drawn.savefig(partial, format="svg", metadata={"Date": None})


def _row(panel: Any, evidence: Evidence, transfer: str, method: str, row: int) -> None:
    paper = PUBLISHED.get((transfer, method))
    if paper:
        panel.plot([paper.rate / 100] * 2, [row - 0.38, row + 0.38], color="#999999", linewidth=2.5,
                   solid_capstyle="butt", zorder=1)  # fmt: skip
    rewards = evidence.rewards()
    found = [(reward, evidence.of(transfer, method, reward)) for reward in rewards]
    if all(run.reward is None for _, runs in found for run in runs):
        found = found[:1]  # the same runs in every block
    for place, (reward, runs) in enumerate(found):
        if not runs:
            continue
        y = row + 0.36 * (place - (len(found) - 1) / 2)
        color, whole = look(method).color, bootstrap([counts(runs)])
        panel.plot([whole.low, whole.high], [y, y], color=color, linewidth=4, alpha=0.3,
                   solid_capstyle="butt", zorder=2)  # fmt: skip
        filled = color if reward == rewards[0] else "white"
        panel.plot([run.success for run in runs], [y] * len(runs), linestyle="", marker="o",
                   markersize=3.6, markerfacecolor=filled, markeredgecolor=color,
                   markeredgewidth=0.9, clip_on=False, zorder=3)  # fmt: skip


def _link_row(panel: Any, evidence: Evidence, transfer: str, link: str, row: int) -> None:
    found = evidence.links.get(transfer)
    if not found or link not in found.links:
        return
    seeds = found.links[link]
    whole = bootstrap([seeds])
    panel.plot([whole.low, whole.high], [row, row], color=LINK_COLOR, linewidth=4, alpha=0.3,
               solid_capstyle="butt", zorder=2)  # fmt: skip
    panel.plot(seeds.rates, [row] * len(seeds.rates), linestyle="", marker="D", markersize=3.2,
               color=LINK_COLOR, clip_on=False, zorder=3)  # fmt: skip


def _keys(panel: Any, evidence: Evidence, methods: bool, links: bool) -> list[Any]:
    rewards, grey = evidence.rewards() if methods else [], "#444444"
    dots = [
        panel.plot([], [], linestyle="", marker="o", markersize=4, markeredgecolor=grey,
                   markerfacecolor=grey if reward == rewards[0] else "white",
                   label=f"a seed, {reward} reward")[0]
        for reward in rewards
    ]  # fmt: skip
    bar = panel.plot([], [], color=grey, alpha=0.3, linewidth=4, label="interval of the IQM")[0]
    paper = panel.plot([], [], color="#999999", linestyle="", marker="|", markersize=9,
                       markeredgewidth=2.5, label="paper")[0]  # fmt: skip
    if links:
        dots += panel.plot([], [], linestyle="", marker="D", markersize=3.6, color=LINK_COLOR,
                           label="a seed, no learning")  # fmt: skip
    return [*dots, bar, *([paper] if methods else [])]
