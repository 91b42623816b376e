"""What the numbers say, as sentences that are computed: they cannot outlive the numbers."""

from __future__ import annotations

from collections.abc import Mapping

from lfr.evaluation.evidence.aggregate import Interval
from lfr.evaluation.evidence.names import method_label
from lfr.evaluation.evidence.published import PUBLISHED, TASKS
from lfr.evaluation.evidence.records import Evidence
from lfr.evaluation.evidence.summary import OURS, summarise
from lfr.evaluation.evidence.tables import percent_interval
from lfr.evaluation.evidence.targets import Rival, Standing, expected_rivals, standing
from lfr.evaluation.tables import markdown


def standings(evidence: Evidence) -> str:
    """One item per transfer and reward: who cannot be told from LfR, who is worse, who better."""
    items = []
    for transfer, task in TASKS.items():
        for reward in evidence.rewards():
            place = standing(evidence, transfer, reward)
            if place:
                seeds = len(evidence.of(transfer, OURS, reward))
                items.append(f"- **{task}, {reward}**: {_sentence(place, seeds)}")
                items[-1] += _unmeasured(place, transfer, reward)
    return "\n".join(items) or "LfR has no run yet."


def _sentence(place: Standing, seeds: int) -> str:
    parts = [f"LfR {percent_interval(place.ours)} over {seeds} seed{'s' * (seeds != 1)}."]
    if place.level:
        parts.append(
            f"Not told apart, the intervals overlapping: {_named(place.level, place.ours)}."
        )
    if place.above:
        parts.append(f"Better: {_named(place.above, place.ours)}.")
    if place.below:
        parts.append(f"Worse: {_named(place.below, place.ours)}.")
    if not (place.level or place.above or place.below):
        parts.append("Nothing to compare it with yet.")
    elif not place.in_the_way:
        parts.append("Its lower end is above every other's upper end.")
    return " ".join(parts)


def _unmeasured(place: Standing, transfer: str, reward: str) -> str:
    known = {**place.in_the_way, **place.below}
    missing = [name for name in expected_rivals(transfer, reward) if name not in known]
    return f" Not measured yet: {', '.join(missing)}." if missing else ""


def _named(others: Mapping[str, Rival], ours: Interval) -> str:
    """With LfR's of the same seeds, where that is another."""
    return ", ".join(
        f"{name}{one.mark} {percent_interval(one.theirs)}"
        + (f" (LfR's of these seeds {percent_interval(one.ours)})" if one.ours != ours else "")
        for name, one in others.items()
    )


def disagreements(evidence: Evidence) -> str:
    """The paper's figures whose interval lies apart from our mean's, largest difference first."""
    found = []
    for (transfer, method), cell in PUBLISHED.items():
        for reward in evidence.rewards():
            ours = summarise(evidence, transfer, method, reward)
            if ours and ours.mean.beside(cell.interval) != "level":
                shown = reward if ours.env_steps is not None else "-"
                points = 100 * ours.mean.value - cell.rate
                row = [TASKS[transfer], method_label(method), shown,
                       percent_interval(cell.interval), percent_interval(ours.mean),
                       f"{points:+.1f}"]  # fmt: skip
                if (points, row) not in found:  # one without a reward: once
                    found.append((points, row))
    if not found:
        return "None of the figures measured so far.\n"
    rows = [row for _, row in sorted(found, key=lambda one: -abs(one[0]))]
    return markdown(["task", "method", "reward", "paper", "here, mean", "points"], rows)
