"""Files as the evidence's stages leave them, with numbers chosen by hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lfr.artifacts import write_json
from lfr.evaluation.statistics import success_of

RUN = {
    "seconds": 1800.0,
    "peak_memory": 2**30,
    "provenance": {"revision": "c0ffee", "modified": False},
}


def rate(successes: int, episodes: int = 100) -> dict[str, Any]:
    return {**vars(success_of(successes, episodes)), "steps": 40.0}


def learned(
    paper: Path,
    transfer: str,
    method: str,
    successes: Mapping[str, Sequence[int]],
    before: int = 50,
    steps: int = 10_000,
    stage: str = "learn",
) -> None:
    """One learning stage: successes of 100 by reward, a seed each; stock is one less.

    Every curve goes in a straight line from ``before`` to the final rate.
    """
    runs, rows = [], ["reward,seed,env_steps,updates,success,kl"]
    for reward, found in successes.items():
        for seed, count in enumerate(found):
            success = {"engine": rate(count), "robosuite": rate(max(count - 1, 0))}
            runs.append({"reward": reward, "seed": seed, "env_steps": steps, "seconds": 90.0,
                         "zero_shot": rate(before), "success": success})  # fmt: skip
            half = (before + count) / 200
            for at, value in ((0, before / 100), (steps // 2, half), (steps, count / 100)):
                rows.append(f"{reward},{seed},{at},0,{value},")
    file = paper / stage / f"{transfer}-{method}"
    about = {"transfer": transfer, "method": method, "judge": "engine", "warm_up": 6000}
    write_json(file.with_name(f"{file.name}.json"), {**about, "runs": runs, **RUN})
    file.with_name(f"{file.name}.csv").write_text("\n".join(rows) + "\n")


def imitated(paper: Path, transfer: str, successes: Sequence[int], stage: str = "imitate") -> None:
    runs = [
        {"seed": seed, "seconds": 60.0, "success": {"engine": rate(count)}}
        for seed, count in enumerate(successes)
    ]
    about = {"transfer": transfer, "method": "bc_rnn", "judge": "engine", "runs": runs}
    write_json(paper / stage / f"{transfer}.json", {**about, **RUN})


def zero_shot(
    paper: Path,
    transfer: str,
    links: Mapping[str, Sequence[int]],
    stage: str = "zero_shot",
    set_back: Sequence[str] = (),
) -> None:
    """Success of links, a seed each, as ``stage`` writes it: "zero_shot", "plain", or
    "plain_parts" with the parts that were set back."""
    found = {
        link: {"runs": [{"seed": seed, **rate(count)} for seed, count in enumerate(counts)]}
        for link, counts in links.items()
    }
    about = {"transfer": transfer, **({"set_back": list(set_back)} if set_back else {})}
    name = "-".join([transfer, *set_back])
    write_json(paper / stage / f"{name}.json", {**about, "links": found, **RUN})
