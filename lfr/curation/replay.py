"""Recorded actions run again: the executed actions of a log, from its first simulator state."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lfr.artifacts import file_hash
from lfr.curation.checks.logs import default_folder, episode_logs, has_logs
from lfr.curation.contents import INFO, Contents
from lfr.curation.finding import readable
from lfr.data.log_reader import list_logs, read_log
from lfr.errors import DataError, LfrError

# Of any number of the state: positions (m, rad), velocities, accelerations of the warm start. On
# the machine and with the libraries that recorded, the difference is 0. Another processor may round
# the last bit otherwise, and contacts make much of little: there, give a tolerance by hand.
TOLERANCE = 1e-9


@dataclass(frozen=True)
class Replay:
    """One episode, run again.

    Attributes:
        episode: its number; log: its file.
        frames: actions that were run.
        difference: largest absolute difference of any number of any state; inf where the physics
            diverged or could not be started from the log's first state.
        step: the first action after which a difference is above the tolerance; None if none is.
        success: whether the replay succeeded; recorded: whether the log says so.
        problem: why it was not run to its end, in words.
    """

    episode: int
    log: Path
    frames: int
    difference: float
    step: int | None
    success: bool
    recorded: bool
    problem: str = ""

    @property
    def same(self) -> bool:
        return self.step is None and not self.problem and self.success == self.recorded

    def __str__(self) -> str:
        name = f"episode {self.episode} ({self.log.name}): "
        if self.problem:
            return f"{name}NOT REPLAYED: {self.problem}"
        exact = "exactly the same"
        if self.difference != 0:
            exact = f"largest |difference| {self.difference:.3g}"
        if self.step is not None:
            return f"{name}DIFFERENT after action {self.step} of {self.frames}, {exact}"
        outcome = ""
        if self.success != self.recorded:
            found = "success" if self.success else "no success"
            outcome = f", but {found}, unlike the log: DIFFERENT"
        return f"{name}{self.frames} actions, states {exact}{outcome}"


def find_logs(path: Path) -> list[tuple[int, Path]]:
    """The logs at `path`, each with its episode: a log, a folder of logs, or a dataset's logs.

    Raises:
        DataError: there are none, or a dataset's are not those that it was packed from.
    """
    if path.is_file():
        return [(0, path)]
    if not (path / INFO).is_file():
        return list(enumerate(list_logs(path)))
    with readable(path):
        contents = Contents.open(path)
        logs = episode_logs(contents) if has_logs(contents) else []
    folder = default_folder(path)
    if not logs or folder is None:
        raise DataError(
            "a dataset holds no simulator states, and its logs are not there; give their folder",
            file=path,
            expected=f"data/logs/{path.resolve().name} beside data/lerobot",
        )
    found = []
    for episode, (name, sha256) in enumerate(logs):
        log = folder / Path(str(name)).name
        if not log.is_file() or file_hash(log) != sha256:
            raise DataError("not the log that the episode was packed from", file=log,
                            episode=episode)  # fmt: skip
        found.append((episode, log))
    return found


def replay_log(log: Path, episode: int = 0, tolerance: float = TOLERANCE) -> Replay:
    """Run a log's executed actions from its first simulator state and compare the states.

    Args:
        log: an MCAP log with T executed actions and T + 1 states.
        episode: its number, for the answer.
        tolerance: of the largest absolute difference, see `TOLERANCE`.

    Raises:
        DataError: the log cannot be read.
        LfrError: its robot or task is unknown.
    """
    from lfr.sim.simulation import simulation

    recorded = read_log(log)
    if recorded.executed_action is None:
        raise DataError("no executed actions", file=log)
    actions, states = recorded.executed_action, recorded.simulator_state
    running = simulation(recorded.robot, recorded.task)
    try:
        running.set_state(states[0])
    except ValueError as error:  # of another revision of the simulation
        problem = str(error)
        return Replay(episode, log, 0, np.inf, 0, False, recorded.success, problem)
    difference, step, success = 0.0, None, False
    for t, action in enumerate(actions):
        steps = running.step(action[None])
        if steps.diverged:
            problem = f"the physics diverged at action {t}"
            return Replay(episode, log, t, np.inf, t, success, recorded.success, problem)
        success |= bool(steps.successes[-1])
        off = float(np.abs(running.state() - states[t + 1]).max())
        off = off if np.isfinite(off) else np.inf
        difference = max(difference, off)
        if step is None and off > tolerance:
            step = t
    return Replay(episode, log, len(actions), difference, step, success, recorded.success)


def chosen(logs: list[tuple[int, Path]], episode: int | None) -> list[tuple[int, Path]]:
    """All of them, or the one of this episode.

    Raises:
        LfrError: there is no such episode.
    """
    if episode is None:
        return logs
    found = [pair for pair in logs if pair[0] == episode]
    if not found:
        raise LfrError(f"no episode {episode}; expected 0 to {len(logs) - 1}")
    return found
