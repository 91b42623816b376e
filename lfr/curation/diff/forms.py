"""What `lfr diff` takes, as a LeRobot v3.0 dataset's folder."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lfr.curation.verify_logs import has_logs
from lfr.data.log_reader import list_logs, read_log
from lfr.data.opening import opened
from lfr.data.source import Source, known


@contextmanager
def as_dataset(path: Path) -> Iterator[Path]:
    """The folder to read what is at `path` from, which need not be of v3.0 nor here.

    Logs are packed into a temporary dataset, as the pipeline packs them.

    Args:
        path: as `lfr.data.opening.opened` takes it; or a log of this project, or a folder of logs.

    Raises:
        LfrError: as of `opened`; logs that cannot be packed.
    """
    with opened(path) as folder:
        if not has_logs(folder):
            yield folder
            return
        with _packed(path) as packed:
            yield packed


@contextmanager
def _packed(path: Path) -> Iterator[Path]:
    from lfr.data.dataset import pack_dataset

    logs = list_logs(path) if path.is_dir() else [path]
    fps = read_log(logs[0]).metadata["fps"]
    with tempfile.TemporaryDirectory(prefix="lfr-diff-") as name:
        packed = Path(name).resolve() / "packed"
        pack_dataset(logs, packed, fps=fps)
        with known(Source(packed, packed, str(path))):
            yield packed
