"""The checkers: how each is installed, in an environment of its own, and how it is run."""

from __future__ import annotations

import os
import resource
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from benchmarks.checkers.findings import Said, said
from lfr.artifacts import code_fingerprint
from lfr.errors import LfrError

SECONDS = 240  # of processor time that a checker may take for one dataset
MEMORY = 12 * 2**30  # bytes of address space
OWN = "lfr"


@dataclass(frozen=True)
class Checker:
    """One checker of LeRobot datasets.

    Attributes:
        name: of its column in the table.
        package: what is installed from PyPI, with its extras; "" for this project.
        command: what is run; {dataset} is the folder, {report} where its JSON report is to go,
            without which it prints that.
        pictures: what is added for faults of videos, where a checker looks into them if asked.
        beside_lerobot: it imports LeRobot, so it is installed beside this project's, alone.
    """

    name: str
    package: str
    command: tuple[str, ...]
    pictures: tuple[str, ...] = ()
    beside_lerobot: tuple[str, ...] = ()

    def run(self, work: Path, dataset: Path, *, pictures: bool, logs: Path | None = None) -> Said:
        """What it says of a dataset.

        Args:
            work: where `install` has put it.
            pictures: whether it is to look into the videos.
            logs: the dataset's, for a checker that can compare them.
        """
        return self.timed(work, dataset, pictures=pictures, logs=logs)[0]

    def timed(
        self, work: Path, dataset: Path, *, pictures: bool, logs: Path | None = None
    ) -> tuple[Said, float]:
        """What it says, and the seconds of processor time that it took."""
        with tempfile.TemporaryDirectory(prefix="report-", dir=work) as folder:
            report = Path(folder) / "report.json"
            words = [*self.command, *(self.pictures if pictures else ())]
            if not self.package and logs is not None and logs.is_dir():
                words += ["--logs", str(logs)]
            words = [word.format(dataset=dataset, report=report) for word in words]
            program = [str(self._folder(work) / "bin" / words[0]), *words[1:]]
            if not self.package:
                program = [sys.executable, "-c", LFR, *words[1:]]
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            code, output, errors = _ended(program, Path(folder), work / "homes" / self.name)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            wrote = report if any("{report}" in word for word in self.command) else None
            spent = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
            return said(code, output, errors, wrote, dataset), spent

    def install(self, work: Path) -> str:
        """Install its newest version, if it is not there, and return the version.

        Raises:
            LfrError: it cannot be installed; the message says why.
        """
        if not self.package:
            return code_fingerprint("lfr.curation", "lfr.data")
        folder = self._folder(work)
        python = folder / "bin" / "python"
        if not python.is_file():
            partial = folder.with_name(f".partial-{self.name}")
            shutil.rmtree(partial, ignore_errors=True)
            _uv("venv", "--quiet", "--relocatable", "--python", sys.executable, str(partial))
            alone = ["--no-deps"] if self.beside_lerobot else []
            into = ["pip", "install", "--quiet", "--python", str(partial / "bin" / "python")]
            _uv(*into, *alone, self.package)
            if self.beside_lerobot:
                _uv(*into, *self.beside_lerobot)
                (own,) = partial.glob("lib/python*/site-packages")
                place = sysconfig.get_path("purelib")
                (own / "lerobot-of-this-project.pth").write_text(f"{place}\n", "utf-8")
            partial.rename(folder)
        listed = _uv("pip", "show", "--python", str(python), self.package.split("[")[0])
        return next(line.split()[1] for line in listed.splitlines() if line.startswith("Version:"))

    def _folder(self, work: Path) -> Path:
        return work / "checkers" / self.name


LFR = "import sys; from lfr.cli import main; sys.exit(main())"

CHECKERS = {
    checker.name: checker
    for checker in (
        Checker(OWN, "", ("lfr", "verify", "{dataset}", "--json"), ("--pictures",)),
        Checker("doctor", "lerobot-doctor", ("lerobot-doctor", "check", "{dataset}", "--json")),
        Checker(
            "lint", "lerobot-lint", ("lelint", "check", "{dataset}", "--json", "{report}"),
            beside_lerobot=("typer", "rich", "pyyaml"),
        ),
        Checker(
            "robovet", "robovet[video]", ("robovet", "doctor", "{dataset}", "--json", "{report}")
        ),
        Checker(
            "kalanos", "kalanos[all]", ("kalanos", "grade", "{dataset}", "--json"),
            ("--tier", "full"),
        ),
        Checker(
            "deepen", "deepen-grade[all]", ("deepen", "grade", "{dataset}", "--json", "--quiet")
        ),
        Checker(
            "rdq", "rdq[video]", ("rdq", "check", "{dataset}", "--no-color", "--json", "{report}"),
            ("--video-full",),
        ),
        Checker(
            "quality-gates", "lerobot-quality-gates",
            ("lerobot-quality-gates", "check", "{dataset}", "--format", "json"),
        ),
        Checker(
            "physlint", "physlint[video]",
            ("physlint", "check", "{dataset}", "--json-output", "{report}"),
        ),
        Checker(
            "rda", "robot-data-audit[parquet,video]",
            ("rda", "audit", "{dataset}", "--format", "json", "-o", "{report}"), ("--full",),
        ),
        Checker(
            "adduct", "adduct[video]", ("adduct", "scan", "{dataset}", "--full", "--json",
                                        "{report}"),
        ),
        Checker(
            "report-card", "robot-report-card[score]", ("rrc", "score", "{dataset}", "--json")
        ),
        Checker("trajlens", "trajlens", ("trajlens", "lint", "{dataset}", "--json"), ("--deep",)),
    )
}  # fmt: skip

NOT_RUN = {
    "datasetlint": "reads folders of pictures and other formats, no LeRobot dataset",
    "robot-data-diff": "says what differs between two datasets, not what is wrong with one",
    "lecop": "is not on PyPI",
}
"""Looked at, and why they have no column."""


def _ended(program: list[str], folder: Path, home: Path) -> tuple[int | None, str, str]:
    """Exit code, None where time ran out, output and errors of a program.

    Args:
        home: of its own, where it has no settings and no caches but what it makes.
    """
    home.mkdir(parents=True, exist_ok=True)
    environment = {
        **os.environ, "HOME": str(home), "XDG_CACHE_HOME": str(home), "NO_COLOR": "1",
        "HF_HOME": str(home), "HF_HUB_OFFLINE": "1", "OMP_NUM_THREADS": "1", "COLUMNS": "200",
        "TQDM_DISABLE": "1", "MPLBACKEND": "agg",
    }  # fmt: skip
    try:
        ended = subprocess.run(
            program, cwd=Path.cwd() if program[0] == sys.executable else folder, env=environment,
            stdin=subprocess.DEVNULL, capture_output=True, timeout=10 * SECONDS,
            preexec_fn=_limited,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return None, "", ""
    if ended.returncode == -signal.SIGXCPU:
        return None, "", ""
    output, errors = (s.decode("utf-8", "replace") for s in (ended.stdout, ended.stderr))
    return ended.returncode, output, errors


def _limited() -> None:
    os.nice(5)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 10))


def _uv(*words: str) -> str:
    found = shutil.which("uv") or next((str(p) for p in (Path(".uv/bin/uv"),) if p.is_file()), None)
    if found is None:
        raise LfrError("no uv to install other checkers with; `make setup` brings it")
    began = time.monotonic()
    ended = subprocess.run([found, *words], capture_output=True, text=True, timeout=1800)
    if ended.returncode:
        last = (ended.stderr.strip().splitlines() or [f"after {time.monotonic() - began:.0f} s"])[0]
        raise LfrError(f"uv {' '.join(words[:2])}: {last}")
    return ended.stdout
