"""Whether the two judges agree: the engine and stock robosuite, episode by episode.

    python -m pipeline.paper._judges

The stages judge every final policy on all held-out starts by the engine and on the first of them in
stock robosuite, and keep in results/ what each counted. Which episodes those were, work/ still says
after a stage: this reads it there and writes results/studies/judges.json. A rate of the first
starts beside one of all of them says nothing of the judges, since some starts are harder.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from lfr.artifacts import provenance, read_json, write_json
from lfr.errors import DataError

WORK = Path("work")
STUDY = Path("results/studies/judges.json")
JUDGES = ("engine", "robosuite")

Outcomes = dict[int, bool]  # start -> success


def main() -> None:
    found = agreement(sorted(WORK.glob("paper-*/*/*/*.json")))
    if not found:
        raise DataError("no policy was judged by both", file=WORK, found=0, expected="one or more")
    write_json(STUDY, {"stages": found, "all": total(found.values()), "provenance": provenance()})


def agreement(files: Iterable[Path]) -> dict[str, dict[str, Any]]:
    """stage -> what `compared` says of all its policies; stages whose files are among ``files``.

    Args:
        files: finished jobs, as `lfr.jobs.run_jobs` keeps them; those that judge no saved policy
            are passed over.
    """
    judged: dict[str, dict[tuple[str, str], dict[str, Outcomes]]] = {}
    for file in files:
        job = read_json(file)
        spec = job.get("spec")
        if not isinstance(spec, dict) or spec.get("judge") not in JUDGES:
            continue
        policy = spec["policy"].get("policy")
        if policy:
            stage = "/".join(Path(policy).parts[1:3])
            of = policy, spec["robot"]  # imitation is judged on the source's own arm too
            outcomes = judged.setdefault(stage, {}).setdefault(of, {})
            outcomes.setdefault(spec["judge"], {}).update(
                {one["seed"]: one["success"] for one in job["result"]}
            )
    both = {
        stage: [one for one in policies.values() if len(one) == len(JUDGES)]
        for stage, policies in sorted(judged.items())
    }
    return {stage: total(map(compared, found)) for stage, found in both.items() if found}


def compared(outcomes: dict[str, Outcomes]) -> dict[str, int]:
    """Of one policy: on the starts that both judged, how often each said success, and they differ;
    and how often the engine did on all of its own."""
    engine, stock = (outcomes[judge] for judge in JUDGES)
    same = engine.keys() & stock.keys()
    return {
        "policies": 1,
        "episodes": len(same),
        "engine": sum(engine[start] for start in same),
        "robosuite": sum(stock[start] for start in same),
        "differ": sum(engine[start] != stock[start] for start in same),
        "engine_all_episodes": len(engine),
        "engine_all": sum(engine.values()),
    }


def total(counts: Iterable[dict[str, int]]) -> dict[str, int]:
    """The sums, key by key."""
    summed: dict[str, int] = {}
    for one in counts:
        for key, value in one.items():
            summed[key] = summed.get(key, 0) + value
    return summed


if __name__ == "__main__":
    main()
