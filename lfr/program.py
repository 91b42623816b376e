"""How a program of lfr starts and ends: arguments, errors in one line, exit codes."""

from __future__ import annotations

import argparse
import errno
import inspect
import os
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from lfr.errors import LfrError

SHELLS = ("sh", "dash", "bash", "zsh", "ksh", "fish")
INTERRUPTED = 130  # what a shell reports for a program ended by Ctrl-C
# Errors of the machine, which the reader can mend, and no traceback helps with.
MACHINE = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM)

EXTRAS = {
    "rerun": "view",
    "ray": "cluster",
    **dict.fromkeys(
        ("dvc", "gymnasium", "lerobot", "llvmlite", "matplotlib", "mujoco", "numba", "robosuite",
         "safetensors", "torch"), "pipeline",
    ),
}  # fmt: skip
"""Which of this project's extras brings a library that the others do without."""


def run_program(main: Callable[[], int | None]) -> int:
    """Call ``main`` and return the exit code, which is its answer or 0.

    An LfrError, a full disk, a folder that may not be written, or a library that an extra would
    bring becomes one line on stderr and exit code 2; Ctrl-C exit code 130. Any other exception is a
    fault of ours and keeps its traceback.
    """
    try:
        return main() or 0
    except LfrError as error:
        print(f"lfr: error: {error}", file=sys.stderr)
        return error.exit_code
    except ModuleNotFoundError as error:
        missing = (error.name or "").partition(".")[0]
        if missing not in EXTRAS:
            raise
        print(
            f"lfr: error: {missing} is not installed; install lfr with its extra "
            f"`{EXTRAS[missing]}`", file=sys.stderr,
        )  # fmt: skip
        return LfrError.exit_code
    except OSError as error:
        if error.errno not in MACHINE:
            raise
        print(f"lfr: error: {error.strerror}: {error.filename}", file=sys.stderr)
        return LfrError.exit_code
    except KeyboardInterrupt:
        print("lfr: stopped", file=sys.stderr)
        return INTERRUPTED


def run_stage(main: Callable[..., None], arguments: Sequence[str] | None = None) -> int:
    """Run a pipeline stage whose keys are the parameters of ``main``, all of them strings.

    ``def main(robot: str, task: str)`` is called by ``python -m pipeline.record --robot panda
    --task lift``; the help is its docstring. A stage ends with
    ``sys.exit(run_stage(main))``.
    """
    parser = argparse.ArgumentParser(
        prog=f"python -m {_module(main)}", description=inspect.getdoc(main)
    )
    for name, parameter in inspect.signature(main).parameters.items():
        required = parameter.default is inspect.Parameter.empty
        option = f"--{name.replace('_', '-')}"
        parser.add_argument(
            option, dest=name, required=required, default=None if required else parameter.default
        )
    keys = vars(parser.parse_args(arguments))
    if "DVC_STAGE" in os.environ:
        end_with_parent()  # the next `dvc repro` would run the stage a second time beside this one
    return run_program(lambda: main(**keys))


def end_with_parent() -> None:
    """End this process once the one that started it has ended, even if that was killed outright.

    Where a shell stands between the two, as DVC's may, that is the one that started the shell.
    """
    parent = os.getppid()
    name, before = _process(parent)
    started = [(os.getpid(), parent)]
    if name in SHELLS:
        started.append((parent, before))
    threading.Thread(target=_end_with, args=(started,), daemon=True).start()


def _end_with(started: list[tuple[int, int]]) -> None:
    """End with any parent of these processes and parents; who loses one is given another."""
    while all(_process(child)[1] == parent for child, parent in started):
        time.sleep(1.0)
    os._exit(1)


def _process(pid: int) -> tuple[str, int]:
    """The name of a process and its parent, 0 where it has ended."""
    if pid == os.getpid():
        return "", os.getppid()
    try:
        stat = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:  # it has ended, or there is no such place, as on macOS
        return "", 0
    name, _, rest = stat.partition("(")[2].rpartition(")")
    return name, int(rest.split()[1])


def _module(main: Callable[..., None]) -> str:
    spec = getattr(sys.modules.get(main.__module__), "__spec__", None)
    return spec.name if spec else main.__module__
