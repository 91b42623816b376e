"""Compilation of the kernel's functions, and the cache that keeps what was compiled.

Numba's own cache notices a change of a function's own file only, not of the functions it calls from
other files. So the cache folder is named by a fingerprint of all the kernel's sources.
"""

import contextlib
import fcntl
import functools
import hashlib
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import mujoco
import numba
import numba.core.config
from numba.extending import register_jitable

from lfr.compiled import MARKED

_SOURCES = (
    *("compiled/*.py", "controllers/*.py", "tasks/*.py"),
    *(f"sim/{name}.py" for name in ("compilation", "cube", "engine", "kernel", "libmujoco")),
    *(f"sim/{name}.py" for name in ("pcg64", "start")),
)
_OPTIONS = {"nogil": True, "error_model": "numpy", "forceinline": True}
_WITHOUT_REFERENCE_COUNTS = {"_nrt": False}
"""What is passed on is alive as long as the simulation is, and compiled code allocates nothing:
counting the references of some 60 arrays at each call would take as long as the torques do. A
function that allocates, or returns an array, does not compile."""
_known: set[Callable[..., Any]] = set()


def entry[F: Callable[..., Any]](function: F) -> F:
    """Compile `function` at its first call, without the GIL; keep the result where possible.

    It may call whatever is `lfr.compiled.compiled`, if `make_callable` came first.
    """
    folder = cache_folder()
    compile_later: Any = numba.njit(cache=folder is not None, **_OPTIONS)
    settings: Any = numba.core.config
    before = settings.CACHE_DIR
    settings.CACHE_DIR = str(folder or before)  # read once, when a function is decorated
    try:
        return compile_later(function)
    finally:
        settings.CACHE_DIR = before


def make_callable() -> None:
    """Let compiled code call every function that is marked as `lfr.compiled.compiled` by now."""
    for function in MARKED:
        if function not in _known:
            register_jitable(**_OPTIONS, **_WITHOUT_REFERENCE_COUNTS)(function)
            _known.add(function)


@functools.cache
def cache_folder() -> Path | None:
    """Where compiled code is kept: beside the sources, or else in the user's cache, or nowhere."""
    digest = hashlib.sha256(f"{numba.__version__} {mujoco.__version__}".encode())
    package = Path(__file__).parent.parent
    for pattern in _SOURCES:
        for source in sorted(package.glob(pattern)):
            digest.update(source.read_bytes())
    return writable_folder(f"kernel-{digest.hexdigest()[:16]}")


def writable_folder(name: str) -> Path | None:
    """A folder called `name` beside the sources, or else in the user's cache, or None."""
    here = Path(__file__).parent / "__pycache__"
    user = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lfr"
    return next(filter(_writable, (here / name, user / name)), None)


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK)


@contextlib.contextmanager
def compiling_once() -> Iterator[None]:
    """Around the first use of the kernel: of several processes one compiles, and says so.

    The others wait for it and read what it kept. Where nothing can be kept, each compiles for
    itself and says why.
    """
    folder = cache_folder()
    if folder is not None and _compiled(folder):
        yield
    elif folder is None:
        _announce("no cache folder can be written (set XDG_CACHE_HOME), so every process does it")
        yield
    else:
        with (folder / "compiling.lock").open("a") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)  # given back when the process dies, too
            if not _compiled(folder):
                _announce(f"kept in {folder}")
            yield


def _compiled(folder: Path) -> bool:
    return any(folder.rglob("kernel.run-*.nbc"))


@functools.cache
def _announce(where: str) -> None:
    text = f"compiling the simulation kernel, about 20 s; {where}"
    print(text, file=sys.stderr, flush=True)
