"""What the evidence cost: hours of all stages and of the paper's tables, seconds of a run."""

from __future__ import annotations

from statistics import median

from lfr.evaluation.evidence.names import method_label
from lfr.evaluation.evidence.published import TABLES
from lfr.evaluation.evidence.records import Evidence

_LEARNED = {
    (transfer, method)
    for table in TABLES.values() for transfer in table.transfers for method in table.methods
}  # fmt: skip
_KEYS = {  # stage -> its keys that the paper's tables need
    "models": {transfer for transfer, _ in _LEARNED},
    "variants": set(TABLES["table3"].transfers),
    "imitate": {transfer for transfer, method in _LEARNED if method == "bc_rnn"},
    "learn": {f"{transfer}-{method}" for transfer, method in _LEARNED},
}


def hours(evidence: Evidence) -> float:
    """Of all stages by the clock, one after the other."""
    return sum(run.seconds for runs in evidence.stages.values() for run in runs.values()) / 3600


def hours_of_tables(evidence: Evidence, reward: str | None = None) -> float:
    """Of what Tables I to III need.

    Args:
        reward: of learning, only the share of the runs with this one, by the seconds that each
            run of a stage took; all of it where None.
    """
    return sum(
        run.seconds * (_share(evidence, key, reward) if stage == "learn" and reward else 1.0)
        for stage, keys in _KEYS.items()
        for key, run in evidence.stages.get(stage, {}).items()
        if key in keys
    ) / 3600  # fmt: skip


def _share(evidence: Evidence, key: str, reward: str) -> float:
    runs = [run for run in evidence.runs if f"{run.transfer}-{run.method}" == key]
    whole = sum(run.seconds or 0.0 for run in runs)
    return sum(run.seconds or 0.0 for run in runs if run.reward == reward) / whole if whole else 0.0


def time_of_tables(evidence: Evidence) -> str:
    """A sentence: the hours that Tables I to III took, with all rewards and with each alone."""
    rewards = evidence.rewards()
    alone = ""
    if len(rewards) > 1:
        each = [f"{hours_of_tables(evidence, reward):.2f} with the {reward}" for reward in rewards]
        alone = f" (with one reward alone, as in the paper: {', '.join(each)})"
    return f"what Tables I to III need took {hours_of_tables(evidence):.2f}{alone}"


def time_of_runs(evidence: Evidence) -> str:
    """A sentence: how long learning takes, run by run, by method."""
    parts = []
    for method in evidence.methods():
        seconds = [run.seconds for run in evidence.runs if run.method == method and run.seconds]
        if seconds:
            label = method_label(method)
            parts.append(f"{label} {median(seconds):.0f} (at most {max(seconds):.0f})")
    if not parts:
        return "No run has been timed yet."
    return (
        f"Seconds of a run's learning, median over all runs: {', '.join(parts)}. Not a comparison "
        "of methods: they ran beside other work, more or less of it, and on two machines."
    )
