"""`dvc repro`, saying between its stages how far the whole is: `python -m pipeline._repro`.

    [17 of 35] skills@panda: about 4 min; about 19 min left for the whole

How long a stage takes is what its committed results say, on
their machine, in the proportion that the stages already run have taken here; a stage that says
nothing of time is not counted. What DVC and the stages print comes through as it is.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

from lfr.artifacts import read_json
from lfr.errors import LfrError
from lfr.program import run_program

RUNNING, SKIPPED = "Running stage '", "Stage '"
"""How DVC begins the line of a stage that it runs, and of one that did not change or that it has
in its cache; these lines speak of skipping, too."""


def stages() -> list[str]:
    """All that `dvc repro` goes through.

    Raises:
        LfrError: DVC cannot tell.
    """
    command = [sys.executable, "-m", "dvc", "stage", "list", "--name-only"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise LfrError(f"dvc stage list: {done.stderr.strip()}")
    return done.stdout.split()


def expected(stage: str, results: Path = Path("results")) -> float:
    """Seconds that a stage took where its results were made; 0 where they do not say."""
    name, _, key = stage.partition("@")
    path = results / name / f"{key}.json"
    return float(read_json(path).get("seconds", 0.0)) if path.is_file() else 0.0


class Plan:
    """Which stages are still to come, and how long they take.

    Args:
        seconds: of each stage, where its results were made.
    """

    def __init__(self, seconds: dict[str, float]) -> None:
        self._left, self._count = dict(seconds), len(seconds)
        self._running: tuple[float, float] | None = None  # its seconds, and when it began
        self._took = self._foreseen = 0.0

    def see(self, line: str, now: float) -> str | None:
        """Take notice of a line that DVC printed; what to say of it, if anything.

        Args:
            now: seconds on any clock that goes on.
        """
        running = line.startswith(RUNNING)
        if not running and not (line.startswith(SKIPPED) and "skipping" in line):
            return None
        self._end(now)
        stage = line.split("'")[1]
        seconds = self._left.pop(stage, 0.0)
        if not running:
            return None
        self._running = (seconds, now)
        place = f"[{self._count - len(self._left)} of {self._count}] {stage}"
        if not seconds:
            return place
        whole = seconds + sum(self._left.values())
        here = _minutes(seconds * self._pace), _minutes(whole * self._pace)
        return f"{place}: about {here[0]}; about {here[1]} left for the whole"

    def _end(self, now: float) -> None:
        if self._running is not None and self._running[0]:
            seconds, began = self._running
            self._took, self._foreseen = self._took + now - began, self._foreseen + seconds
        self._running = None

    @property
    def _pace(self) -> float:
        """Of this machine, from the stages that have ended here; 1 until there is one."""
        return self._took / self._foreseen if self._foreseen else 1.0


def told(lines: Iterable[str], plan: Plan) -> Iterator[str]:
    """The lines, and after one that begins a stage how far the whole is."""
    for line in lines:
        yield line
        said = plan.see(line, time.monotonic())
        if said:
            yield f"{said}\n"


def main() -> int:
    plan = Plan({stage: expected(stage) for stage in stages()})
    command = [sys.executable, "-m", "dvc", "repro"]
    # Bars and errors go where they would: only what DVC says of stages is read.
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in told(process.stdout, plan):
            print(line, end="", flush=True)
    return process.returncode


def _minutes(seconds: float) -> str:
    return f"{seconds / 60:.0f} min" if seconds >= 90 else f"{seconds:.0f} s"


if __name__ == "__main__":
    sys.exit(run_program(main))
