"""The page of what can be said of a mapping without a simulator."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from lfr.evaluation.open_loop import MAPPED, MEAN, OWN

ERRORS, EPISODE, STATES = "errors.svg", "episode.svg", "states.svg"

PAGE = """\
# How far {target} can be trusted with {task}

{target} was never shown {task}; it acts by {source}'s prior through G, and there is no simulator to
try it in. So this is **open loop**: at recorded states of the common tasks, held out of training,
what it would do is held to what was done. Small errors are needed and do not suffice, for nobody
has seen where its own actions lead.

{verdicts}

## Its actions against the recorded ones

Root-mean-square error in the dataset's units. `own prior` is {target}'s own, from the same
demonstrations: what can be reached. `identity` carries out the source's skills as they are, where
both actions have as many numbers. `mean action` knows nothing. `spread` is the standard deviation
of what was recorded.

{errors}

![Errors by dimension]({errors_figure})

![A held-out episode: recorded, mapped, own prior]({episode_figure})

## Its states

The share of states that lie farther from all those of the other column than 99 % of states do that
are of its kind. States of the same kind have 0.01.

| states of | from those of | beyond |
|---|---|---|
{states}
{outside}
![States of the common tasks and of {task}]({states_figure})

## There and back

F(G(z)) against z, by what a map would miss that ignores its input: 0 is the same skill again.

| task | round trip |
|---|---|
{round_trips}
"""


def open_loop_page(report: Mapping[str, Any]) -> str:
    """The page in Markdown, beside whose file the pictures lie."""
    source, target, task = (report[key] for key in ("source", "target", "task"))
    common, new = report["common"], report["new"]
    states = {f"{target}, {name} | {source}, {name}": one for name, one in common.items()}
    states[f"{source}, {task} | both, all common tasks"] = new
    return PAGE.format(
        source=source,
        target=target,
        task=task,
        verdicts="\n".join(f"- {line}" for line in _verdicts(report)),
        errors="\n\n".join(_errors(name, report["actions"], one) for name, one in common.items()),
        states="\n".join(f"| {key} | {one['states_beyond']:.2f} |" for key, one in states.items()),
        outside=_outside(new["dimensions_beyond"], task),
        round_trips="\n".join(
            f"| {name} | {one['round_trip']:.2f} |"
            for name, one in {**common, f"{task}, new": new}.items()
        ),
        errors_figure=ERRORS,
        episode_figure=EPISODE,
        states_figure=STATES,
    )


def _verdicts(report: Mapping[str, Any]) -> Iterable[str]:
    target, task = report["target"], report["task"]
    for name, found in report["common"].items():
        mapped, own, mean = (_overall(found, policy) for policy in (MAPPED, OWN, MEAN))
        yield (
            f"**{name}**: it errs {mapped / own:.1f} times as much as {target}'s own prior, and "
            f"{mapped / mean:.2f} times as much as the mean action."
        )
    yield (
        f"**{task}**: {report['new']['states_beyond']:.0%} of its states lie beyond those of the "
        "common tasks; there G has learned nothing and guesses."
    )


def _overall(found: Mapping[str, Any], policy: str) -> float:
    """Over all dimensions, each by its spread."""
    shares = np.divide(found["errors"][policy], np.maximum(found["spread"], 1e-9))
    return float(np.sqrt(np.mean(np.square(shares))))


def _errors(task: str, actions: Sequence[str], found: Mapping[str, Any]) -> str:
    columns = {**found["errors"], "spread": found["spread"]}
    rows = [f"| {task} | {' | '.join(columns)} |", "|---" * (1 + len(columns)) + "|"]
    for place, name in enumerate(actions):
        values = " | ".join(f"{column[place]:.3g}" for column in columns.values())
        rows.append(f"| {name} | {values} |")
    return "\n".join(rows)


def _outside(shares: Mapping[str, float], task: str) -> str:
    if not shares:
        return ""
    listed = ", ".join(f"`{name}` {share:.0%}" for name, share in [*shares.items()][:6])
    return f"\nStates of {task} outside the range of the common tasks, by dimension: {listed}.\n"
