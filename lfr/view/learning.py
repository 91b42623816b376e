"""Learning runs drawn from what they leave (`lfr.transfer.log`), at their end or as they go on.

    learning.rrd              the curves of `lfr.view.curve`
    episode-<env_steps>.rrd   an episode of each policy that was kept

The episodes all begin where the run's evaluations begin.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from lfr.embodiments import is_known
from lfr.errors import DataError, LfrError
from lfr.transfer.log import CURVE, POLICY, UPDATES
from lfr.transfer.starts import evaluation_starts
from lfr.view import curve
from lfr.view.curve import learning_recording, log_curve, read_curve

if TYPE_CHECKING:
    from lfr.environments.simulation import ExternalSimulation
    from lfr.sim.simulation import Simulation
    from lfr.transfer.actor import SkillActor


class RunRecordings:
    """The recordings of all runs below a folder, made in another and continued by `look`."""

    def __init__(self, folder: Path, out: Path) -> None:
        self.folder, self.out = folder, out
        self._runs: dict[Path, _Run] = {}

    def look(self) -> list[Path]:
        """Draw what the runs have left since the last look; the files that are new."""
        new: list[Path] = []
        for file in sorted(self.folder.rglob(CURVE)):
            run = file.parent
            if run not in self._runs:
                self._runs[run] = _Run(run, self.out / run.relative_to(self.folder))
                new.append(self._runs[run].file)
            new += self._runs[run].look()
        return new

    def close(self) -> None:
        """Finish the files of the curves, which grow until then."""
        for run in self._runs.values():
            run.close()


def save_run(run: Path, out: Path) -> list[Path]:
    """Write the recordings of a run that has ended to the folder ``out``.

    Raises:
        DataError: no run, or a damaged one.
    """
    if not (run / CURVE).is_file():
        raise DataError("the file is missing", file=run / CURVE)
    recordings = RunRecordings(run, out)
    files = recordings.look()
    recordings.close()
    return files


def save_attempt(policy: Path, out: Path, start: int, note: str | None = None) -> None:
    """Write an episode of the policy in a folder, from the start of a seed, to an `.rrd` file.

    Raises:
        DataError: no transferred policy, or one that does not say its arm and task.
    """
    from lfr.transfer.model import load_policy
    from lfr.view.policy_episode import save_policy_episode
    from lfr.view.rollout import roll_out_policy

    actor, about = load_policy(policy)
    for key in ("robot", "task"):
        if key not in about:
            raise DataError("a policy that does not say its arm and task",
                            file=policy / "config.json", column=f"about.{key}")  # fmt: skip
    episode, trace = roll_out_policy(actor, _simulation(actor, about), start)
    save_policy_episode(out, episode, trace, note=note)


def _simulation(actor: SkillActor, about: dict[str, Any]) -> Simulation | ExternalSimulation:
    """Where a policy acts: here, or in the environment that its arm names.

    Raises:
        LfrError: it names none, or one that does not fit.
    """
    from lfr.environments.simulation import external_target
    from lfr.external import external_arms
    from lfr.scenarios import transfer as transfer_named
    from lfr.sim.simulation import simulation
    from lfr.skills.prior import SkillPrior

    robot, task = about["robot"], about["task"]
    if is_known(robot):
        return simulation(robot, task)
    arm, pi = external_arms([robot]).get(robot), actor.policy.pi
    assert isinstance(pi, SkillPrior)  # as every method's of the library
    common = transfer_named(about["transfer"]).common if arm else ()
    target = external_target(robot, arm, task, common, pi.layout_names)
    if target is None:
        raise LfrError(f"{robot} names no environment for {task}, so nothing can be seen of it")
    return target.simulation()


class _Run:
    """The recordings of one run."""

    def __init__(self, run: Path, out: Path) -> None:
        out.mkdir(parents=True, exist_ok=True)
        self.run, self.out, self.file = run, out, out / "learning.rrd"
        self._recording = learning_recording(self.file, _title(run), choice=True)
        self._logged = {CURVE: 0, UPDATES: 0}  # rows of either table
        self._drawn: set[Path] = set()

    def look(self) -> list[Path]:
        """Log the rows that are new; the files of new episodes."""
        for name, quantities in ((CURVE, curve.CURVES), (UPDATES, curve.UPDATES)):
            if (self.run / name).is_file():
                rows = read_curve(self.run / name)
                log_curve(self._recording, rows[self._logged[name] :], quantities)
                self._logged[name] = len(rows)
        self._recording.flush()
        new = [policy for policy in _policies(self.run) if policy not in self._drawn]
        self._drawn.update(new)
        return [self._draw(policy) for policy in new if _is_seen(_about(policy))]

    def close(self) -> None:
        self._recording.flush()
        self._recording.disconnect()

    def _draw(self, policy: Path) -> Path:
        about = _about(policy)
        out = self.out / f"episode-{about['env_steps']:06d}.rrd"
        note = f"{about['env_steps']} environment steps"
        save_attempt(policy, out, evaluation_starts(about["seed"], 1)[0], note)
        return out


def _is_seen(about: dict[str, Any]) -> bool:
    """Whether there is a simulation that shows it."""
    from lfr.external import external_arms

    robot = about["robot"]
    arm = None if is_known(robot) else external_arms([robot]).get(robot)
    return is_known(robot) or (arm is not None and about["task"] in arm.environments)


def _policies(run: Path) -> list[Path]:
    return sorted(run.glob(f"{POLICY}*"))


def _about(policy: Path) -> dict[str, Any]:
    from lfr.transfer.model import load_policy

    return load_policy(policy)[1]


def _title(run: Path) -> str:
    """What the run's policies say of it; without one, or one that says less, its folder's name."""
    for policy in _policies(run)[:1]:
        about = _about(policy)
        if {"transfer", "method", "seed"} <= about.keys():
            return f"{about['transfer']} {about['method']} seed {about['seed']}"
    return run.resolve().name
