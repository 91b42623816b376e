"""Runs that nobody has run."""

from __future__ import annotations

from typing import Any

from studies.evidence.runs import Run


def run(outcomes: str = "1110", **of: Any) -> Run:
    transfer = of.setdefault("transfer", "s2-panda-joint_position-stack")
    values: dict[str, Any] = {
        "task": "stack", "source": "sawyer", "source_controller": "joint_position",
        "target": "panda", "target_controller": "joint_position", "method": "lfr",
        "option": "ours" if of.get("method", "lfr") in ("lfr", "linear") else "",
        "reward": "sparse" if of.get("env_steps") else "", "demonstrations": 50, "seed": 0,
        "env_steps": 0, "judge": "engine", "revision": "abc", "processor": "a processor",
        "seconds": 12.5 if of.get("env_steps") else None, **of, "transfer": transfer,
    }  # fmt: skip
    return Run(**values, starts=len(outcomes), successes=outcomes.count("1"), outcomes=outcomes)
