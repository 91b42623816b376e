"""The tables of the report, in Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import fmean
from typing import Any

from lfr.evaluation.names import NAMES, PAPER
from lfr.evaluation.records import CHAIN, Record, StageRun


def markdown(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A Markdown table, its columns padded so that it reads as plain text too."""
    cells = [[str(cell) for cell in row] for row in (header, *rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(header))]
    lines = ["| " + " | ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) + " |"
             for row in cells]  # fmt: skip
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join(lines) + "\n"


def percent(rate: float, interval: Sequence[float] | None = None) -> str:
    """``92 (85-96)``: a rate in percent with its interval."""
    if interval is None:
        return f"{100 * rate:.0f}"
    low, high = interval
    return f"{100 * rate:.0f} ({100 * low:.0f}-{100 * high:.0f})"


def summary(records: Sequence[Record], chains: Mapping[str, Record]) -> dict[str, dict[str, float]]:
    """``<transfer>-<method>`` -> success along the chain, before and after learning, mean of seeds.

    This is what DVC shows as metrics; `lfr.evaluation.records.transfer_records` has every run.
    """
    groups: dict[str, list[Record]] = {}
    for record in records:
        groups.setdefault(f"{record['transfer']}-{record['method']}", []).append(record)
    return {
        name: {
            **{
                link: found["rate"]
                for link, found in chains[runs[0]["transfer"]]["zero_shot"].items()
            },
            "zero_shot": fmean(record["zero_shot"] for record in runs),
            "success": fmean(record["success"] for record in runs),
            "env_steps": fmean(record["env_steps"] for record in runs),
            "seeds": len(runs),
        }
        for name, runs in groups.items()
    }


WITHOUT_G, RIVALS = ("identity", "no_generator", "linear"), ("retarget", "oracle")
"""Links of the chain that stand beside a run: in G's place, and what the run is measured by."""


def transfer_table(records: Sequence[Record], chains: Mapping[str, Record]) -> str:
    """Success before and after learning beside its transfer's chain, percent, one row per run."""
    judges = list(dict.fromkeys(name for record in records for name in record["other_judges"]))
    header = ["transfer", "method", "reward", "seed", *map(_words, WITHOUT_G), "zero-shot",
              "after RL", *(f"after RL, {judge}" for judge in judges), *map(_words, RIVALS),
              "environment steps"]  # fmt: skip

    def links(record: Record, names: Sequence[str]) -> list[str]:
        found = chains[record["transfer"]]["zero_shot"] if record["transfer"] in chains else {}
        return [percent(found[name]["rate"]) if name in found else "-" for name in names]

    rows = [
        [
            record["transfer"],
            record["method"],
            record["reward"],
            record["seed"],
            *links(record, WITHOUT_G),
            percent(record["zero_shot"], record["zero_shot_interval"]),
            percent(record["success"], record["success_interval"]),
            *(percent(record["other_judges"][judge]) for judge in judges),
            *links(record, RIVALS),
            record["env_steps"],
        ]
        for record in records
    ]
    return markdown(header, rows)


def headline_table(records: Sequence[Record], chains: Mapping[str, Record]) -> str:
    """What a reader asks first, in percent, one row per transfer and method, means of seeds."""
    header = ["new task", "target", "learns from", "LfR, not learned", "LfR, learned", "identity",
              "linear", "retarget", "oracle", "paper"]  # fmt: skip
    groups: dict[tuple[str, str], list[Record]] = {}
    for record in records:
        groups.setdefault((record["transfer"], record["method"]), []).append(record)
    rows = []
    for (transfer, method), runs in groups.items():
        chain = chains[transfer]
        found = chain["zero_shot"]
        target = chain["target"].partition("-")[0]
        task = chain["task"]
        paper = PAPER.get((task, target), {}).get(method)
        links = ("identity", "linear", "retarget", "oracle")
        rows.append([
            NAMES.get(task, task), _called(chain["target"]),
            _called(chain["source"]), percent(fmean(run["zero_shot"] for run in runs)),
            percent(fmean(run["success"] for run in runs)),
            *(percent(found[link]["rate"]) if link in found else "-" for link in links),
            "-" if paper is None else f"{paper:.1f}",
        ])  # fmt: skip
    return markdown(header, rows)


def _called(robot: str) -> str:
    arm, _, controller = robot.partition("-")
    return f"{NAMES.get(arm, arm)}, {NAMES.get(controller or 'osc_pose', controller)}"


def chain_table(chains: Mapping[str, Record]) -> str:
    """Zero-shot success link by link, one row per transfer."""
    header = ["transfer", "from", "to", *map(_words, CHAIN)]
    rows = []
    for name, chain in chains.items():
        found = [chain["zero_shot"].get(link) for link in CHAIN]
        rates = [percent(one["rate"], (one["low"], one["high"])) if one else "-" for one in found]
        rows.append([name, chain["source"], chain["target"], *rates])
    return markdown(header, rows)


def demonstration_table(recorded: Mapping[str, Mapping[str, Any]]) -> str:
    """What the expert did, one row per robot and task."""
    header = ["robot-task", "episodes", "attempts", "expert %", "frames", "median length"]
    rows = [
        [
            name,
            one["episodes"],
            one["attempts"],
            percent(one["expert_success"]),
            one["frames"],
            f"{one['length']['median']:.0f}",
        ]
        for name, one in recorded.items()
    ]
    return markdown(header, rows)


def skill_table(skills: Mapping[str, Mapping[str, Any]]) -> str:
    """Every prior on its own arm and task, one row per prior."""
    header = ["robot", "tasks seen", "task", "own arm %", "KL held out", "position RMSE"]
    rows = []
    for robot, stage in skills.items():
        for model in stage["models"].values():
            for task, prior in model["prior"].items():
                own, kl = prior.get("own_arm"), prior["kl_held_out"]  # no success without simulator
                rate = percent(own["rate"], (own["low"], own["high"])) if own else "-"
                rows.append([robot, ", ".join(model["tasks"]), task, rate,
                             "-" if kl is None else f"{kl:.1f}",
                             _position(model["held_out"][task]["rmse"])])  # fmt: skip
    return markdown(header, rows)


def mapping_table(mappings: Mapping[str, Mapping[str, Any]]) -> str:
    """Errors of G and F on held-out states, one row per transfer and task."""
    columns = ("regression_g", "regression_f", "cycle_x", "cycle_y", "spread_x", "spread_y",
               "hand_difference", "hand_motion")  # fmt: skip
    header = ["transfer", "task", *map(_words, columns), "decoded"]
    rows = []
    for transfer, found in mappings.items():
        for kind in ("common", "new"):
            for task, one in found[kind].items():
                numbers = [f"{one[name]:.2f}" if name in one else "-" for name in columns]
                name = f"{task} (new)" if kind == "new" else task
                rows.append([transfer, name, *numbers, _position(one["decoded_difference"])])
    return markdown(header, rows)


def _words(name: str) -> str:
    return name.replace("_", " ")


def _position(by_dimension: Mapping[str, float]) -> str:
    """The mean over the position actions; a dash for arms whose actions are no positions."""
    axes = ("dx", "dy", "dz")
    if not set(axes) <= set(by_dimension):
        return "-"
    return f"{fmean(by_dimension[axis] for axis in axes):.3f}"


def stage_table(stages: Mapping[str, Mapping[str, StageRun]]) -> str:
    """Wall-clock, largest process and git revisions of the stages' runs, one row per stage."""
    rows = [_stage_row(stage, list(keys.values())) for stage, keys in stages.items()]
    every = [run for keys in stages.values() for run in keys.values()]
    rows.append([*_stage_row("all", every)[:-1], ""])
    return markdown(["stage", "runs", "seconds", "peak GiB", "git revision"], rows)


def _stage_row(name: str, runs: Sequence[StageRun]) -> list[object]:
    measured = [run.peak_memory for run in runs if run.peak_memory is not None]
    peak = f"{max(measured) / 2**30:.2f}" if measured else "-"
    revisions = ", ".join(dict.fromkeys(run.revision for run in runs))
    return [name, len(runs), f"{sum(run.seconds for run in runs):.0f}", peak, revisions]
