"""What a learning run leaves of its course, written while it learns; nothing of it is drawn here.

    curve.csv             a row for each evaluation (`lfr.transfer.observer.CurvePoint`)
    updates.csv           a row for each round of updates, with their means
    policy-<env_steps>/   the policy as it was at some of the evaluations

A run that was killed and has gone on leaves the same as one that was not.
"""

from __future__ import annotations

import csv
import dataclasses
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lfr.artifacts import write_whole
from lfr.transfer.actor import SkillActor
from lfr.transfer.model import save_policy
from lfr.transfer.observer import CurvePoint, Observer

CURVE, UPDATES, POLICY = "curve.csv", "updates.csv", "policy-"
KEPT_AT = (0.0, 0.5, 1.0)  # parts of the run; the policy of the first evaluation from each on
COLUMNS = ("env_steps", "updates", "kl", "alpha", "sigma", "q", "critic_loss", "policy_loss")


class LearningLog(Observer):
    """Writes a run down in a folder.

    Args:
        folder: made if missing.
        actor: that learns.
        about: what is stored with each policy (robot, task, seed, ...), beside its ``env_steps``.
    """

    def __init__(self, folder: Path, actor: SkillActor, about: Mapping[str, Any]) -> None:
        self.folder, self.actor, self.about = folder, actor, about
        points = [field.name for field in dataclasses.fields(CurvePoint)]
        self._curve, self._updates = _Table(folder / CURVE, points), _Table(folder / UPDATES)
        self._total = 0  # environment steps of the run, once it has said so

    def on_update(self, env_steps: int, updates: int, info: Mapping[str, float]) -> None:
        self._updates.add({"env_steps": env_steps, "updates": updates, **info})

    def on_evaluation(self, point: CurvePoint) -> None:
        before = self._curve.before(point.env_steps)
        if any(before < part * self._total <= point.env_steps for part in KEPT_AT):
            about = {**self.about, "env_steps": point.env_steps}
            save_policy(self.folder / f"{POLICY}{point.env_steps:06d}", self.actor, about)
        self._curve.add(dataclasses.asdict(point))  # whoever finds the row finds the policy

    def on_progress(self, env_steps: int, total: int) -> None:
        self._total = total


class _Table:
    """A CSV file that grows by rows of rising ``env_steps``.

    A run that goes on from a checkpoint comes again to rows that were written before it was
    killed; these and all after them make room for what it writes.
    """

    def __init__(self, path: Path, columns: Sequence[str] = COLUMNS) -> None:
        self.path, self.columns = path, columns
        self._last: int | None = None  # env_steps of the last row, None until one is added

    def add(self, row: Mapping[str, Any]) -> None:
        """Write a row; the first one makes room for itself."""
        if self._last is None:
            kept = self._written_before(row["env_steps"])
            with write_whole(self.path) as partial:
                header = ",".join(self.columns) + "\n"
                partial.write_text(header + self._text([*kept, row]), encoding="utf-8")
        else:
            with self.path.open("a", encoding="utf-8") as stream:
                stream.write(self._text([row]))
        self._last = row["env_steps"]

    def before(self, env_steps: int) -> int:
        """The ``env_steps`` of the row before one of these, -1 if that is the first."""
        if self._last is not None:
            return self._last
        kept = self._written_before(env_steps)
        return int(kept[-1]["env_steps"]) if kept else -1

    def _written_before(self, env_steps: int) -> list[dict[str, str]]:
        if not self.path.is_file():
            return []
        text = self.path.read_text(encoding="utf-8")
        whole = text[: text.rfind("\n") + 1]  # without a row that was cut off
        rows = csv.DictReader(io.StringIO(whole))
        return [row for row in rows if int(row["env_steps"]) < env_steps]

    def _text(self, rows: Sequence[Mapping[str, Any]]) -> str:
        out = io.StringIO()
        csv.DictWriter(out, self.columns, lineterminator="\n").writerows(rows)
        return out.getvalue()
