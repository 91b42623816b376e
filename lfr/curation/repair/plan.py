"""All that can be mended of a dataset, worked out aside; nothing of the dataset is written."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from lfr.curation.checks.logs import default_folder
from lfr.curation.contents import INFO
from lfr.curation.finding import Finding, Unreadable
from lfr.curation.repair.counts import mend_counts
from lfr.curation.repair.draft import Draft, Repair, Unmendable
from lfr.curation.repair.episodes import mend_episodes
from lfr.curation.repair.info import is_lost, mend_info
from lfr.curation.repair.rows import mend_rows
from lfr.curation.repair.statistics import mend_statistics
from lfr.curation.repair.tasks import mend_tasks
from lfr.curation.verify import Report, verify_dataset
from lfr.errors import DataError

# Each step reads what the steps before it have mended.
STEPS: tuple[Callable[[Draft], None], ...] = (
    mend_info, mend_rows, mend_tasks, mend_episodes, mend_statistics, mend_counts,
)  # fmt: skip


@dataclass(frozen=True)
class Plan:
    """What is wrong with a dataset, and what of it can be mended.

    Attributes:
        before: what verifying it found.
        draft: the mended dataset, aside.
        after: what verifying that found: what is left.
    """

    before: Report
    draft: Draft
    after: Report

    @property
    def repairs(self) -> list[Repair]:
        return self.draft.repairs

    @property
    def reasons(self) -> list[str]:
        """Why something is not mended, where there is more to say than the findings do."""
        return self.draft.reasons


@contextmanager
def planned(path: Path, logs: Path | None = None, pictures: int | None = None) -> Iterator[Plan]:
    """Work out what can be mended of the dataset at `path`.

    Args:
        path: the dataset's folder; nothing is written to it.
        logs, pictures: as for `lfr.curation.verify.verify_dataset`.

    Yields:
        The plan, whose draft is there as long as the context is.

    Raises:
        DataError: there is no LeRobot v3.0 dataset, nor what is left of one.
    """
    path = Path(path)
    logs = logs or default_folder(path)
    before = inspect(path, logs, pictures)
    with tempfile.TemporaryDirectory(prefix="lfr-fix-") as folder:
        if not before.findings:
            yield Plan(before, Draft(Path(folder)), before)
            return
        draft = Draft.of(path, Path(folder))
        for step in STEPS:
            try:
                step(draft)
            except Unmendable as reason:
                draft.not_mended(reason)
            except (Unreadable, DataError):
                continue  # what cannot be read is a finding
        after = before if not draft.changed else inspect(draft.path, logs, pictures)
        yield Plan(before, draft, replace(after, path=path))


def inspect(path: Path, logs: Path | None = None, pictures: int | None = None) -> Report:
    """`verify_dataset`, of a dataset without info.json too, where the rest looks like one."""
    try:
        return verify_dataset(path, logs, pictures)
    except DataError:
        if not is_lost(path):
            raise
    what = "lost, or without the version of its format"
    return Report(path, (Finding("missing-file", what, file=INFO),))
