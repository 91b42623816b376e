"""Another method, or a link without learning, beside LfR: of the seeds that both have.

Of five seeds the interquartile mean leaves out the lowest, of three none, so more seeds alone would
look better.
"""

from __future__ import annotations

from dataclasses import dataclass

from lfr.evaluation.evidence.aggregate import Seeds
from lfr.evaluation.evidence.names import link_label, method_label
from lfr.evaluation.evidence.records import Evidence, counts, of_seeds
from lfr.evaluation.evidence.summary import OURS

NO_LEARNING = (
    "identity",
    "recoded",
    "shared_vae",
)  # links that are policies of their own, without LfR's G


@dataclass(frozen=True)
class Pair:
    """Theirs and LfR's, or another's, of the same N seeds of one transfer under one reward."""

    theirs: Seeds
    ours: Seeds


def no_learning(link: str) -> str:
    """What a zero-shot link is called beside methods that learn."""
    return f"{link_label(link)} (no learning)"


def pairs(evidence: Evidence, transfer: str, reward: str) -> dict[str, Pair]:
    """label -> pair, of every method and of `NO_LEARNING`, in the tables' order; LfR's own too.

    One that shares no seed with LfR is left out.
    """
    found = {
        method_label(method): method_pair(evidence, transfer, method, reward)
        for method in evidence.methods([transfer])
    }
    for link in NO_LEARNING:
        found[no_learning(link)] = _link_pair(evidence, transfer, link, reward)
    return {label: pair for label, pair in found.items() if pair}


def method_pair(
    evidence: Evidence, transfer: str, method: str, reward: str, beside: str = OURS
) -> Pair | None:
    """A method's; None where it shares no seed with the one that it is set beside."""
    theirs, ours = (evidence.of(transfer, name, reward) for name in (method, beside))
    shared = {run.seed for run in theirs} & {run.seed for run in ours}
    if not shared:
        return None
    return Pair(counts(of_seeds(theirs, shared)), counts(of_seeds(ours, shared)))


def _link_pair(evidence: Evidence, transfer: str, link: str, reward: str) -> Pair | None:
    found, ours = evidence.links.get(transfer), evidence.of(transfer, OURS, reward)
    if not found or link not in found.links:
        return None
    shared = set(found.seeds[link]) & {run.seed for run in ours}
    if not shared:
        return None
    return Pair(found.only(link, shared).links[link], counts(of_seeds(ours, shared)))
