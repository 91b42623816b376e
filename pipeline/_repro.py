"""`dvc repro`, several stages at a time: `python -m pipeline._repro [--at-once 2]`.

    36 of 36 stages to run, 2 at a time; what they print is in work/repro
    [1 of 36] record@panda-joint_position-lift begins; about 24 min left
    [1 of 36] record@panda-joint_position-lift: 43 s

DVC runs one stage after the other, and many stages here have work for one core alone, or wait for
their imports. It allows several `dvc repro` side by side, though, and this is what runs here, one
stage each. How long a stage takes is what its committed results say, on their machine, in the
proportion that the stages already run have taken here.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import IO

from lfr.artifacts import provenance, read_json, write_json
from lfr.errors import LfrError, ParameterError
from lfr.program import run_program
from pipeline._dag import dvc_dag, stages_before
from pipeline._plan import Plan

LOGS, RESULT = Path("work/repro"), Path("results/repro.json")
LAST = 20  # lines that are shown of a stage that has failed
RAN = "Running stage '"  # in what DVC prints of one that it did not find done
CLEAR = "\r\x1b[K"  # of a terminal's line

# `dvc`, which ends when this program does, even if that is killed outright.
DVC = """
import sys
from lfr.program import end_with_parent
end_with_parent()
from dvc.cli import main
sys.exit(main(sys.argv[1:]))
"""


def expected(stage: str, results: Path = Path("results")) -> float:
    """Seconds that a stage took where its results were made; 0 where they do not say."""
    name, _, key = stage.partition("@")
    path = results / name / f"{key}.json"
    return float(read_json(path).get("seconds", 0.0)) if path.is_file() else 0.0


def to_run(before: Mapping[str, Collection[str]], changed: Collection[str]) -> dict[str, set[str]]:
    """Of the graph what has changed and all that depends on it."""
    found: dict[str, bool] = {}

    def concerned(stage: str) -> bool:
        if stage not in found:
            # a list, so that every stage before is looked at
            found[stage] = stage in changed or any([concerned(one) for one in before[stage]])
        return found[stage]

    chosen = [stage for stage in before if concerned(stage)]
    return {stage: set(before[stage]).intersection(chosen) for stage in chosen}


def changed_stages() -> list[str]:
    """Those that are not as dvc.lock has them.

    Raises:
        LfrError: DVC cannot tell.
    """
    command = [sys.executable, "-m", "dvc", "--wait-for-lock", "status", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise LfrError(f"dvc status: {done.stderr.strip()}")
    return list(json.loads(done.stdout or "{}"))


class Stages:
    """The stages that run, each a `dvc repro` of its own with a file for what it prints."""

    def __init__(self, logs: Path = LOGS) -> None:
        self._logs = logs
        self._running: dict[str, tuple[subprocess.Popen[bytes], IO[bytes]]] = {}
        shutil.rmtree(logs, ignore_errors=True)
        logs.mkdir(parents=True)

    def start(self, stage: str) -> None:
        log = self.log(stage).open("wb")
        command = [sys.executable, "-c", DVC, "--wait-for-lock", "repro", "--single-item", stage]
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT,
            env={"LFR_PROGRESS": "1", **os.environ},
        )  # fmt: skip
        self._running[stage] = process, log

    def ended(self) -> dict[str, int]:
        """Those that have ended since, and their exit codes."""
        found = {}
        for stage, (process, log) in list(self._running.items()):
            if (code := process.poll()) is not None:
                found[stage] = code
                log.close()
                del self._running[stage]
        return found

    def stop(self) -> None:
        """End what still runs; finished jobs are kept, so that the next run goes on."""
        for process, _ in self._running.values():
            process.terminate()
        for process, log in self._running.values():
            process.wait()
            log.close()
        self._running.clear()

    def log(self, stage: str) -> Path:
        return self._logs / f"{stage.replace('/', '_')}.log"

    def last(self, stage: str, count: int = 1) -> list[str]:
        """The last lines that it printed."""
        text = self.log(stage).read_text(encoding="utf-8", errors="replace")
        return [line for line in text.splitlines() if line.strip()][-count:]


def run(plan: Plan, stages: Stages) -> None:
    """Run the plan, saying what begins and what has ended.

    Raises:
        LfrError: a stage failed; the others are ended.
    """
    place: dict[str, str] = {}
    while not plan.done:
        while (stage := plan.begin(time.monotonic())) is not None:
            place[stage] = f"[{len(place) + 1} of {plan.count}] {stage}"
            stages.start(stage)
            _say(f"{place[stage]} begins{_left(plan)}")
        time.sleep(0.2)
        for stage, code in stages.ended().items():
            if code:
                for line in stages.last(stage, LAST):
                    _say(f"    {line}")
                raise LfrError(f"{stage} failed; all that it printed is in {stages.log(stage)}")
            ran = any(line.startswith(RAN) for line in stages.last(stage, 10_000))
            took = plan.end(stage, time.monotonic(), ran=ran)
            _say(f"{place[stage]}: {_minutes(took) if ran else 'unchanged'}")
        _show(f"{one}: {'; '.join(stages.last(one))}" for one in plan.running)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--at-once", type=int, default=2, help="how many stages run at a time")
    options = parser.parse_args()
    if options.at_once < 1:
        raise ParameterError(f"--at-once: found {options.at_once}, expected at least 1")
    began, before = time.monotonic(), stages_before(dvc_dag())
    asked = to_run(before, changed_stages())
    if not asked:
        _say(f"all {len(before)} stages are up to date")
        return 0
    _say(f"{len(asked)} of {len(before)} stages to run, {options.at_once} at a time; what they "
         f"print is in {LOGS}")  # fmt: skip
    stages = Stages()
    try:
        run(Plan(asked, {stage: expected(stage) for stage in asked}, options.at_once), stages)
    finally:
        stages.stop()
    seconds = round(time.monotonic() - began, 1)
    _say(f"done in {_minutes(seconds)}")
    if len(asked) == len(before):
        measured = {"seconds": seconds, "stages": len(asked), "at_once": options.at_once}
        write_json(RESULT, {**measured, "provenance": provenance()})
    return 0


def _left(plan: Plan) -> str:
    seconds = plan.left(time.monotonic())
    return f"; about {_minutes(seconds)} left" if seconds else ""


def _minutes(seconds: float) -> str:
    return f"{seconds / 60:.0f} min" if seconds >= 90 else f"{seconds:.0f} s"


def _say(line: str) -> None:
    print(f"{CLEAR if sys.stdout.isatty() else ''}{line}", flush=True)


def _show(parts: Iterable[str]) -> None:
    """What runs at the moment, on a terminal's last line, which the next one overwrites."""
    if sys.stdout.isatty():
        line = " | ".join(parts)[: shutil.get_terminal_size().columns - 1]
        print(f"{CLEAR}{line}", end="", flush=True)


if __name__ == "__main__":
    sys.exit(run_program(main))
