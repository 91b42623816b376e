"""`lfr replay PATH`: whether recorded actions give the recorded states again."""

from __future__ import annotations

import argparse
from pathlib import Path

DIFFERENT = 1  # exit code


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr replay`."""
    from lfr.curation.replay import TOLERANCE

    parser.add_argument(
        "path", type=Path, help="an MCAP log, a folder of logs, or a dataset whose logs are there"
    )
    parser.add_argument("--episode", type=int, help="this one only")
    parser.add_argument(
        "--tolerance",
        type=float,
        default=TOLERANCE,
        help="largest absolute difference of a state that passes (default %(default)g; on the "
        "machine that recorded, states come back exactly)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Replay episode by episode; 1 when the states of one do not come back.

    Raises:
        LfrError: no logs, a log that cannot be read, or an unknown robot or task.
    """
    from lfr.curation.replay import chosen, find_logs, replay_log
    from lfr.progress import progress

    logs = chosen(find_logs(arguments.path), arguments.episode)
    replays = []
    with progress(logs, f"replay {arguments.path.name}", "episode") as bar:
        for episode, log in bar:
            replays.append(replay_log(log, episode, arguments.tolerance))
            bar.write(str(replays[-1]))
    same = sum(replay.same for replay in replays)
    exact = sum(replay.same and replay.difference == 0 for replay in replays)
    print(f"{arguments.path}: {same} of {len(replays)} episodes come back, {exact} exactly")
    return 0 if same == len(replays) else DIFFERENT
