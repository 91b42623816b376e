"""The figure of the report: learning curves as small multiples."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lfr.artifacts import write_whole

if TYPE_CHECKING:
    from lfr.evaluation.records import Record

COLORS = ("#1b6ca8", "#c4572e", "#3a8f5c", "#7a5195", "#8a8a8a")  # told apart when printed grey
STYLE: dict[Any, Any] = {
    "svg.hashsalt": "lfr",  # the same figure, the same bytes
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "axes.edgecolor": "#555555",
    "xtick.color": "#555555",
    "ytick.color": "#555555",
}

Curve = list[dict[str, float]]


def read_curves(path: Path) -> dict[int, Curve]:
    """A transfer stage's CSV: seed -> its points in order."""
    curves: dict[int, Curve] = {}
    with path.open(newline="", encoding="utf-8") as stream:
        for row in csv.DictReader(stream):
            point = {key: float(row[key]) for key in ("env_steps", "success")}
            curves.setdefault(int(row["seed"]), []).append(point)
    return curves


def learning_figure(
    path: Path,
    curves: Mapping[tuple[str, str], Mapping[int, Curve]],
    records: Sequence[Record],
    warm_up: int,
) -> None:
    """Success against environment steps, one panel per transfer, as SVG.

    Thin lines are the evaluations while learning, one for each seed, on a few starts; dots with
    bars at both ends are the held-out results and their Wilson intervals.

    Args:
        curves: (transfer, method) -> seed -> curve.
        records: of `lfr.evaluation.records.transfer_records`.
        warm_up: environment steps, counted, in which the policy does not change yet; shaded.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    transfers = list(dict.fromkeys(transfer for transfer, _ in curves))
    methods = list(dict.fromkeys(method for _, method in curves))
    with rc_context(STYLE):
        columns = min(len(transfers), 4)
        rows = -(-len(transfers) // columns)
        figure = Figure(figsize=(2.6 * columns + 0.5, 2.3 * rows + 0.4), layout="constrained")
        axes = figure.subplots(rows, columns, sharey=True, squeeze=False).flat
        for panel in axes[len(transfers) :]:
            panel.set_visible(False)
        for panel, transfer in zip(axes, transfers, strict=False):
            panel.set_title("\n".join(transfer.rsplit("-", 1)), loc="left")  # who, and what
            panel.axvspan(0, warm_up / 1000, color="#000000", alpha=0.06, linewidth=0)
            panel.grid(axis="y", color="#e5e5e5", linewidth=0.6)
            panel.set_axisbelow(True)
            panel.set_ylim(-0.03, 1.03)
            panel.set_yticks([0, 0.25, 0.5, 0.75, 1], ["0", "", "50", "", "100 %"])
            for method, color in zip(methods, COLORS * len(methods), strict=False):
                for curve in curves.get((transfer, method), {}).values():
                    steps = [point["env_steps"] / 1000 for point in curve]
                    panel.plot(steps, [p["success"] for p in curve], color=color, linewidth=1.1)
                for record in records:
                    if (record["transfer"], record["method"]) == (transfer, method):
                        _mark(panel, record, color)
        figure.supxlabel("environment steps, thousands (shaded: warm-up)", fontsize=9)
        figure.supylabel("success", fontsize=9)
        if len(methods) > 1:
            lines = zip(methods, COLORS, strict=False)
            handles = [axes[0].plot([], [], color=color, label=name)[0] for name, color in lines]
            figure.legend(handles=handles, loc="outside upper right", ncols=len(methods))
        with write_whole(path) as partial:
            figure.savefig(partial, format="svg", metadata={"Date": None})


def _mark(panel: Any, record: Record, color: str) -> None:
    ends = (("zero_shot", 0, "white"), ("success", record["env_steps"] / 1000, color))
    for name, steps, filled in ends:
        rate, (low, high) = record[name], record[f"{name}_interval"]
        panel.errorbar(
            steps, rate, yerr=[[rate - low], [high - rate]], color=color, marker="o",
            markersize=4.5, markerfacecolor=filled, capsize=2, linewidth=1, clip_on=False, zorder=3,
        )  # fmt: skip
