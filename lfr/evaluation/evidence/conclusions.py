"""What the paper concludes from its tables and curves, and whether it is so here."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from lfr.evaluation.evidence.aggregate import Place, bootstrap
from lfr.evaluation.evidence.names import method_label
from lfr.evaluation.evidence.pairs import method_pair
from lfr.evaluation.evidence.published import ABLATIONS, BASELINES, TASKS
from lfr.evaluation.evidence.records import Evidence
from lfr.evaluation.evidence.summary import OURS, summarise
from lfr.evaluation.evidence.tables import DASH, percent
from lfr.evaluation.tables import markdown

WORDS: dict[Place, str] = {"above": "so", "level": "not told apart", "below": "the other way"}


class Conclusion(NamedTuple):
    """The paper's words, and what was measured of it; None before anything was."""

    paper: str
    here: Callable[[Evidence], str | None]


def conclusions_table(evidence: Evidence) -> str:
    """A row for each conclusion: how many comparisons of task and reward bear it out."""
    rows: list[list[object]] = [[one.paper, one.here(evidence) or DASH] for one in CONCLUSIONS]
    return markdown(["the paper", "here"], rows)


def _more_often(first: str, *others: str) -> Callable[[Evidence], str | None]:
    """Whether one succeeds more often than others, by interquartile means of shared seeds."""

    def here(evidence: Evidence) -> str | None:
        said = (_against(evidence, first, other) for other in others)
        return "; ".join(filter(None, said)) or None

    return here


def _against(evidence: Evidence, first: str, other: str) -> str | None:
    """``than AP: so in 1 of 8, not told apart in 7``, by whether their intervals are apart."""
    found: list[Place] = []
    for transfer in TASKS:
        for reward in evidence.rewards():
            pair = method_pair(evidence, transfer, other, reward, beside=first)
            if pair:
                found.append(bootstrap([pair.ours]).beside(bootstrap([pair.theirs])))
    if not found:
        return None
    parts = [f"{word} in {found.count(place)}" for place, word in WORDS.items() if place in found]
    return f"than {method_label(other)}: {', '.join(parts)} of {len(found)}"


def _sooner(*others: str) -> Callable[[Evidence], str | None]:
    """By the area under the curve, the mean over seeds."""

    def here(evidence: Evidence) -> str | None:
        parts = []
        for other in others:
            found = [
                ours.auc - theirs.auc
                for transfer in TASKS
                for reward in evidence.rewards()
                if (ours := summarise(evidence, transfer, OURS, reward))
                and (theirs := summarise(evidence, transfer, other, reward))
                and ours.auc is not None
                and theirs.auc is not None
            ]
            if found:
                ahead = sum(lead > 0 for lead in found)
                parts.append(
                    f"than {method_label(other)}: its area is larger in {ahead} of {len(found)}, "
                    f"by {min(found):+.3f} to {max(found):+.3f}"
                )
        return "; ".join(parts) or None

    return here


def _fails(method: str) -> Callable[[Evidence], str | None]:
    """The range of its mean success."""

    def here(evidence: Evidence) -> str | None:
        means = [
            found.mean.value
            for transfer in TASKS
            for reward in evidence.rewards()
            if (found := summarise(evidence, transfer, method, reward))
        ]
        if not means:
            return None
        return f"{percent(min(means))} to {percent(max(means))} in {len(means)}"

    return here


NO_GENERATOR, ONLY_LIFT, ONLY_NUT_ASSEMBLY = ABLATIONS
CONCLUSIONS = (
    Conclusion("LfR succeeds more often than the baselines", _more_often(OURS, *BASELINES)),
    Conclusion("LfR learns faster (Figures 3 and 4)", _sooner("ap", "sac")),
    Conclusion("without the generator both robots struggle", _fails(NO_GENERATOR)),
    Conclusion("two common tasks are better than one",
               _more_often(OURS, ONLY_LIFT, ONLY_NUT_ASSEMBLY)),
    Conclusion("Nut Assembly alone does more than Lift alone",
               _more_often(ONLY_NUT_ASSEMBLY, ONLY_LIFT)),
)  # fmt: skip
