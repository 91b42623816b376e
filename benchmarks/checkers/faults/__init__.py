"""All planted faults, and changes of a dataset that are none."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.checkers.dataset_copy import DatasetCopy
from benchmarks.checkers.faults import behaviour, episodes, files, meta, rows, videos
from benchmarks.checkers.faults.fault import Fault

CONTROL = "control"


def _rewritten(copy: DatasetCopy) -> None:
    for file in ("rows", "episodes"):
        table = getattr(copy, file)
        setattr(copy, file, table.slice(0, 1))
        copy.save()
        setattr(copy, file, table)


def _rebuilt(copy: DatasetCopy) -> None:
    parts = [np.r_[copy.span(e)] for e in range(copy.episodes.num_rows)]
    copy.rebuild(parts, range(len(parts)))


CONTROLS = {
    "unchanged_own": Fault(CONTROL, lambda copy: None, ""),
    "unchanged_arm": Fault(CONTROL, lambda copy: None, "", "arm"),
    "unchanged_arm2d": Fault(CONTROL, lambda copy: None, "", "arm2d"),
    "rewritten_own": Fault(CONTROL, _rewritten, ""),
    "encoded_again_own": Fault(CONTROL, lambda copy: copy.film(copy.frames()), ""),
    "counted_again_arm": Fault(CONTROL, _rebuilt, "", "arm"),
}

FAULTS: dict[str, Fault] = {
    **rows.FAULTS, **meta.FAULTS, **files.FAULTS, **videos.FAULTS, **behaviour.FAULTS,
    **episodes.FAULTS, **CONTROLS,
}  # fmt: skip

GROUPS = list(dict.fromkeys(fault.group for fault in FAULTS.values()))


def plant(name: str, bases: Path, out: Path) -> DatasetCopy:
    """A copy, at `out`, of the clean dataset of a fault, with the fault in it."""
    fault = FAULTS[name]
    copy = DatasetCopy.of(bases / fault.base, out)
    fault.plant(copy)
    copy.save()
    return copy
