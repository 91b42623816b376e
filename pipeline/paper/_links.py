"""Zero-shot links of several seeds, judged: what zero_shot, plain and plain_parts do alike."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lfr.evaluation.trials import Trial, success_rates

CODE = (
    "lfr.ablations.other_task", "lfr.mapping", "lfr.skills", "lfr.models", "lfr.sim", "lfr.seeds",
    "lfr.robots", "lfr.tasks",
    "lfr.evaluation.chain", "lfr.evaluation.questions", "lfr.policies",
    "lfr.evaluation.trials",
)  # fmt: skip


def judged_links(
    trials: Mapping[tuple[int, str], Trial], work: Path, title: str
) -> dict[str, dict[str, list[Any]]]:
    """link -> its success for each seed, as `lfr.evaluation.evidence.records.Links` reads it.

    Args:
        trials: by seed and link. One names its policy by content, so that another seed runs its
            own trials alone.
        work: folder of finished trials, for `CODE`.
    """
    named = {f"{seed}/{link}": trial for (seed, link), trial in trials.items()}
    success = success_rates(named, work, title)
    links: dict[str, dict[str, list[Any]]] = {}
    for seed, link in trials:
        runs = links.setdefault(link, {"runs": []})["runs"]
        runs.append({"seed": seed, **success[f"{seed}/{link}"]})
    return links
