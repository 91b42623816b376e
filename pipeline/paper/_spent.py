"""How long a stage's work took, whoever did it: hours of jobs outlive many a process."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any

from lfr.artifacts import read_json, write_json
from lfr.jobs import peak_memory
from pipeline._stage import BEGAN, MADE_BY

TICK = 15.0  # seconds that a kill may leave out


class Spent:
    """Wall-clock seconds of a stage's processes that shared a folder of unfinished work.

    A stage that is killed and started again finds its finished jobs there; without what they took
    it would say of hours of work that it took seconds.
    """

    def __init__(self, work: Path) -> None:
        self._file = work / "spent.json"
        self._before = read_json(self._file)["seconds"] if self._file.is_file() else 0.0
        self._lock = threading.Lock()
        threading.Thread(target=self._keep, daemon=True).start()

    @property
    def seconds(self) -> float:
        """Those of earlier processes, and of this one since it began."""
        return self._before + time.perf_counter() - BEGAN

    def write(self, stage: str, key: str, metrics: dict[str, Any]) -> None:
        """Write results/paper/<stage>/<key>.json, as `pipeline._stage.write_metrics` does."""
        self._note()
        run = {
            "seconds": round(self.seconds, 1),
            "peak_memory": peak_memory(),
            "provenance": MADE_BY,
        }
        write_json(Path("results/paper") / stage / f"{key}.json", {**metrics, **run})

    def _keep(self) -> None:
        while True:
            time.sleep(TICK)
            self._note()

    def _note(self) -> None:
        with self._lock:
            if self._file.parent.is_dir():
                write_json(self._file, {"seconds": self.seconds})
