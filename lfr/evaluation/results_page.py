"""The report in words: what was run, on what, and what came of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lfr.artifacts import read_json
from lfr.evaluation import results_tables as tables
from lfr.evaluation.records import RESULTS, Record, StageRun, stage_runs


def report(
    records: Sequence[Record],
    chains: Mapping[str, Record],
    results: Path = RESULTS,
    *,
    external: Sequence[str] = (),
) -> str:
    """Markdown: success, the chain, the skills, the demonstrations, and how the stages ran.

    Args:
        external: transfers between arms without a simulator; they have skills and a mapping alone.
    """
    recorded = _all(results / "record")
    named = (*chains, *external)
    mappings = {name: one for name, one in _all(results / "mapping").items() if name in named}
    arms = {one[side] for one in (*chains.values(), *mappings.values())
            for side in ("source", "target")}  # fmt: skip
    skills = {name: one for name, one in _all(results / "skills").items() if name in arms}
    datasets = {name: digest for one in records for name, digest in
                one["revisions"]["datasets"].items()}  # fmt: skip
    stages = stage_runs(results)
    steps = sorted({record["env_steps"] for record in records})
    judges = dict.fromkeys(record["judge"] for record in records)
    return f"""# Results

Success by robosuite's own check within the horizon, on held-out starts, percent with the Wilson
interval of 95 %. Judge: {", ".join(judges)}. Zero-shot is before any learning on the target arm.

{tables.transfer_table(records, chains)}
![Success against environment steps](learning.svg)

## The chain

Zero-shot success on the new task, link by link: the source's prior on its own arm; its actions as
they are on the target; its skills with the target's decoder, nothing between; its actions through
the target's skill VAE; its skills through the best linear map; through G; its motions of the hand,
where both arms' kinematic models are needed to say them; and the target's own prior, had it been
shown the task.

{tables.chain_table(chains)}
## Skill priors on their own arm

Divergence of the posterior to the prior (nats) and reconstruction error of the position actions
are of held-out episodes.

{tables.skill_table(skills)}
## Mapping

Of held-out states, L1 over the 2Z numbers of a distribution (Eq. 5 and 6); "spread" is what a
mapping that ignores its input would reach. On the new task the target has no prior, which leaves
the cycle from the source. "Decoded" is the root-mean-square difference of the position actions
between the source's decoder and, through G, the target's; "hand difference" is that of the hand's
motions, both arms', beside the source's own, in units of 5 cm and 0.5 rad.

{tables.mapping_table(mappings)}
## Demonstrations

{tables.demonstration_table(recorded)}
## What was run on what

{_versions(stages)}
- Seeds of the runs: {", ".join(str(s) for s in sorted({r["seed"] for r in records}))}.
- Environment steps of a run, warm-up counted: {", ".join(map(str, steps))}.

Datasets, by the SHA-256 of their rows:

{tables.markdown(["dataset", "rows"], [[n, d[:16]] for n, d in sorted(datasets.items())])}
## Stages

Of each stage's last run for every robot and task, or transfer and method: the wall-clock, summed;
the peak memory of the largest process; the git revisions, with a plus sign where the sources
differed from what was committed.

{tables.stage_table(stages)}"""


def _versions(stages: Mapping[str, Mapping[str, StageRun]]) -> str:
    """One item for each set of versions that a stage was run with."""
    found: dict[str, list[str]] = {}
    for stage, keys in stages.items():
        for made in (run.provenance for run in keys.values() if "packages" in run.provenance):
            packages = ", ".join(f"{name} {version}" for name, version in made["packages"].items())
            found.setdefault(
                f"Python {made['python']}, {made['platform']}; {packages}.", []
            ).append(stage)
    named = {text: ", ".join(dict.fromkeys(names)) for text, names in found.items()}
    return "\n".join(f"- {names}: {text}" for text, names in named.items())


def _all(folder: Path) -> dict[str, Any]:
    return {file.stem: read_json(file) for file in sorted(folder.glob("*.json"))}
