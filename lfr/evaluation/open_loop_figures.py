"""Pictures of what can be said of a mapping without a simulator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch

from lfr.evaluation.figures import COLORS, STYLE
from lfr.evaluation.open_loop import MAPPED, OWN, Episode, States


def errors_figure(path: Path, report: Mapping[str, Any]) -> None:
    """Errors of every policy by dimension, as shares of what was recorded varies by."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    names = report["actions"]
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 1.0 + 0.5 * len(names)), layout="constrained")
        grid = figure.subplots(1, len(report["common"]), squeeze=False, sharex=True, sharey=True)
        panels = grid[0]
        for panel, (task, found) in zip(panels, report["common"].items(), strict=True):
            policies = list(found["errors"])
            height = 0.8 / len(policies)
            for number, (policy, color) in enumerate(zip(policies, COLORS, strict=False)):
                share = np.divide(found["errors"][policy], np.maximum(found["spread"], 1e-9))
                places = np.arange(len(names)) + (number - (len(policies) - 1) / 2) * height
                panel.barh(places, share, 0.9 * height, color=color, label=policy)
            panel.axvline(1.0, color="#888888", linewidth=0.8, linestyle=":")
            panel.set_title(task)
            panel.set_xlabel("error by spread")
        panels[0].set_yticks(range(len(names)), names)
        panels[0].invert_yaxis()
        _legend(figure, panels[0])
        figure.savefig(path, metadata={"Date": None})


def episode_figure(path: Path, episodes: Sequence[Episode]) -> None:
    """Of each common task one held-out episode: every action dimension over its control steps."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    names = episodes[0].space.names
    shown = {"recorded": "#222222", MAPPED: COLORS[0], OWN: COLORS[1]}
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 0.7 + 0.85 * len(names)), layout="constrained")
        panels = figure.subplots(
            len(names), len(episodes), squeeze=False, sharex="col", sharey="row"
        )
        for column, episode in enumerate(episodes):
            courses = (episode.recorded, episode.mapped, episode.own)
            for row, name in enumerate(names):
                panel = panels[row, column]
                for (label, color), course in zip(shown.items(), courses, strict=True):
                    width = 2.2 if label == "recorded" else 1.1
                    panel.plot(course[:, row], color=color, linewidth=width, label=label)
                if column == 0:
                    panel.set_ylabel(name, rotation=0, ha="right", va="center")
            panels[0, column].set_title(episode.task)
            panels[-1, column].set_xlabel("control step")
        _legend(figure, panels[0, 0])
        figure.savefig(path, metadata={"Date": None})


def states_figure(path: Path, states: States, task: str) -> None:
    """States of the common tasks and of the new one, along their first principal components."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    everything = torch.cat([*states.common.values(), states.new])
    centre = everything.mean(0)
    _, _, directions = torch.linalg.svd(everything - centre, full_matrices=False)
    with rc_context(STYLE):
        figure = Figure(figsize=(4.6, 3.6), layout="constrained")
        panel = figure.subplots()
        sets = {f"{robot}, common tasks": found for robot, found in states.common.items()}
        sets[f"{task}, new"] = states.new
        for (label, found), color in zip(sets.items(), COLORS, strict=False):
            x, y = ((found - centre) @ directions[:2].T).T
            panel.scatter(
                x, y, s=4, alpha=0.4, linewidths=0, color=color, label=label, rasterized=True
            )
        panel.set_xlabel("first principal component of the states")
        panel.set_ylabel("second")
        panel.legend(frameon=False, markerscale=3)
        figure.savefig(path, metadata={"Date": None}, dpi=150)


def _legend(figure: Any, panel: Any) -> None:
    handles, labels = panel.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
