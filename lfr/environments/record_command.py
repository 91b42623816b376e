"""``lfr record``: demonstrations in an arm's own environment, by a policy of one's own."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from lfr.params import PARAMS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr record`."""
    parser.add_argument("arm", help="one of external.arms in params.yaml, with environments")
    parser.add_argument("task", help="one of its environments")
    parser.add_argument(
        "--policy", required=True,
        help="module:name of what makes a policy for one episode (called with the environment's "
        "observation, or its get_action is), or the folder of a policy in LeRobot's format",
    )  # fmt: skip
    parser.add_argument(
        "--to", type=Path, required=True, help="the dataset, e.g. under data/external"
    )
    parser.add_argument("--logs", type=Path, help="of MCAP logs (default data/logs/<ARM>-<TASK>)")
    parser.add_argument("--episodes", type=int, default=50, help="successful ones (default 50)")
    parser.add_argument(
        "--attempts", type=float, default=4.0, help="for each, before it gives up (default 4)"
    )
    parser.add_argument(
        "--noise", type=float, default=0.0,
        help="on actions as they are carried out, in shares of half their range; recorded is what "
        "the policy asked for (default 0)",
    )  # fmt: skip
    parser.add_argument(
        "--linger", type=float, default=0.5, help="seconds recorded after success (default 0.5)"
    )
    parser.add_argument("--params", type=Path, default=PARAMS, help=f"default {PARAMS}")


def run(options: argparse.Namespace) -> int:
    """Record, and say what came of it.

    Raises:
        LfrError: see `record_in_environment`.
    """
    from lfr.artifacts import fingerprint, work_folder
    from lfr.environments.recording import Manner, record_in_environment
    from lfr.errors import UnknownNameError
    from lfr.external import external

    if os.getcwd() not in sys.path:  # where the policy's module may lie
        sys.path.append(os.getcwd())
    arms = external(options.params).arms
    if options.arm not in arms:
        raise UnknownNameError("external arm", options.arm, arms)
    arm, manner = arms[options.arm], Manner(options.policy, options.noise, options.linger)
    name = f"{options.arm}-{options.task}"
    logs = options.logs or Path("data/logs") / name
    work = work_folder("record", fingerprint(name, arm, manner))
    found = record_in_environment(
        options.arm, arm, options.task, manner, options.episodes, options.attempts, logs,
        options.to, work,
    )  # fmt: skip
    length = found["length"]
    print(
        f"{found['episodes']} episodes of {length['min']} to {length['max']} frames, "
        f"{found['failures']} of {found['attempts']} attempts failed"
    )
    print(f"{options.to}, a LeRobot dataset; {logs}, its logs")
    return 0
