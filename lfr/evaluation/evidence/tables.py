"""The evidence's tables, in Markdown: the paper's three, and every method of a transfer."""

from __future__ import annotations

from collections.abc import Sequence

from lfr.evaluation.evidence.aggregate import Interval, bootstrap, difference, improvement, mean
from lfr.evaluation.evidence.curves import LEVELS
from lfr.evaluation.evidence.links import Links
from lfr.evaluation.evidence.names import LINKS, METHODS, in_order, method_label
from lfr.evaluation.evidence.pairs import Pair, pairs
from lfr.evaluation.evidence.published import PUBLISHED, TASKS, PaperTable
from lfr.evaluation.evidence.records import Evidence
from lfr.evaluation.evidence.summary import OURS, Summary, summarise
from lfr.evaluation.tables import markdown

DASH = "-"


def percent(rate: float | None) -> str:
    """``97.4``; a dash where nothing was measured."""
    return DASH if rate is None else f"{100 * rate:.1f}"


def percent_interval(found: Interval) -> str:
    """``97.4 [95.0, 98.8]``"""
    return f"{percent(found.value)} [{percent(found.low)}, {percent(found.high)}]"


def points_interval(found: Interval) -> str:
    """``+1.0 [+0.4, +1.6]``"""
    ends = (round(100 * end, 1) + 0.0 for end in (found.value, found.low, found.high))  # no -0.0
    value, low, high = (f"{end:+.1f}" for end in ends)
    return f"{value} [{low}, {high}]"


def paper_table(table: PaperTable, evidence: Evidence) -> str:
    """One of the paper's tables, a block for each reward: ours and, below it, the paper's row.

    A cell of ours: the mean over seeds, then the interquartile mean with its bootstrap interval,
    then the number of seeds.
    """
    blocks = [f"# {table.name}: {table.about}\n"]
    for reward in evidence.rewards():
        header = ["task", "", *(method_label(method) for method in table.methods)]
        rows = []
        for transfer in table.transfers:
            ours = [summarise(evidence, transfer, method, reward) for method in table.methods]
            theirs = [PUBLISHED.get((transfer, method), DASH) for method in table.methods]
            rows.append([TASKS[transfer], "here", *(_cell(one) for one in ours)])
            rows.append(["", "paper", *theirs])
        blocks.append(f"## {reward.capitalize()} reward\n")
        blocks.append(markdown(header, rows))
    blocks.append(
        "Percent of held-out episodes: mean over seeds; interquartile mean (IQM) with its "
        "stratified bootstrap interval of 95 %; n seeds. BC+RNN takes no reward and is the same in "
        "each block. Paper: mean ± standard deviation of 3 tests of 10 trials.\n"
    )
    return "\n".join(blocks)


def _cell(found: Summary | None) -> str:
    if found is None:
        return f"{DASH} (n = 0)"
    return f"{percent(found.mean.value)}; IQM {percent_interval(found.iqm)}; n = {len(found.seeds)}"


def methods_table(found: Sequence[Summary]) -> str:
    """All that is known of each method on one transfer, a row for each reward."""
    levels = [f"steps to {100 * level:.0f} %" for level in LEVELS]
    header = ["method", "reward", "seeds", "mean", "IQM", "each seed", "zero-shot", "robosuite",
              "area", "steps", *levels, "P(LfR better)"]  # fmt: skip
    rows = [
        [
            method_label(one.method),
            one.reward,
            len(one.seeds),
            percent_interval(one.mean),
            percent_interval(one.iqm),
            ", ".join(f"{100 * rate:.0f}" for rate in one.rates),
            percent(one.zero_shot),
            percent(one.stock),
            DASH if one.auc is None else f"{one.auc:.3f}",
            DASH if one.env_steps is None else one.env_steps,
            *_steps(one),
            DASH if one.improvement is None else _probability(one.improvement),
        ]
        for one in found
    ]
    return markdown(header, rows)


def _steps(one: Summary) -> list[str]:
    if not one.steps_to:
        return [DASH] * len(LEVELS)
    return ["never" if steps is None else f"{steps:.0f}" for steps in one.steps_to]


def _probability(found: Interval) -> str:
    return f"{found.value:.2f} [{found.low:.2f}, {found.high:.2f}]"


def overall_table(evidence: Evidence) -> str:
    """Every method, and links without learning, over all transfers that they and LfR have.

    Stratified over these; LfR's is of the seeds that both have.
    """
    header = ["method", "reward", "tasks", "IQM", "LfR's IQM there", "LfR's mean less this",
              "P(LfR better)"]  # fmt: skip
    rows = []
    for reward in evidence.rewards():
        for label, found in over_tasks(evidence, reward).items():
            theirs, ours = ([getattr(pair, side) for pair in found] for side in ("theirs", "ours"))
            against = [DASH, DASH]
            if label != method_label(OURS):
                points = points_interval(difference(ours, theirs))
                against = [points, _probability(improvement(ours, theirs))]
            rows.append([label, reward, len(found), percent_interval(bootstrap(theirs)),
                         percent_interval(bootstrap(ours)), *against])  # fmt: skip
    return markdown(header, rows)


def over_tasks(evidence: Evidence, reward: str) -> dict[str, list[Pair]]:
    """label -> its pair on each transfer that has one."""
    found: dict[str, list[Pair]] = {}
    for transfer in TASKS:
        for label, pair in pairs(evidence, transfer, reward).items():
            found.setdefault(label, []).append(pair)
    return {label: found[label] for label in sorted(found, key=_order)}


def _order(label: str) -> int:
    """Methods as in the other tables, then links."""
    labels = list(METHODS.values())
    return labels.index(label) if label in labels else len(labels)


def questions_table(evidence: Evidence) -> str:
    """The zero-shot links, one row each, one column per transfer."""
    found = [evidence.links.get(transfer) for transfer in TASKS]
    names = in_order((link for one in found if one for link in one.links), LINKS)
    if not names:
        return "They have not been run yet.\n"
    header = ["link", "what it asks", *TASKS.values()]
    rows = [
        [f"`{name}`", LINKS.get(name, ""), *(link_cell(one, name) for one in found)]
        for name in names
    ]
    return markdown(header, rows)


def link_cell(found: Links | None, name: str) -> str:
    """``97.5 [95.0, 98.8] (98, 97)``: the mean with its bootstrap interval, and each seed."""
    if found is None or name not in found.links:
        return DASH
    seeds = found.links[name]
    each = ", ".join(f"{100 * rate:.0f}" for rate in seeds.rates)
    return f"{percent_interval(bootstrap([seeds], mean))} ({each})"
