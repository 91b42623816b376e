"""Compilation of the kernel's functions, and the cache that keeps what was compiled.

Numba's own cache notices a change of a function's own file only, not of the functions it calls from
other files. So the cache folder is named by a fingerprint of all the kernel's sources.
"""

import functools
import hashlib
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numba
import numba.core.config

_SOURCES = ("compilation", "kernel", "libmujoco", "observation", "osc", "rewards", "scene")


def compiled[F: Callable[..., Any]](function: F) -> F:
    """Compile `function` at its first call, without the GIL; keep the result where possible."""
    folder = cache_folder()
    compile_later: Any = numba.njit(
        nogil=True, cache=folder is not None, error_model="numpy", forceinline=True
    )
    settings: Any = numba.core.config
    before = settings.CACHE_DIR
    settings.CACHE_DIR = str(folder or before)  # read once, when a function is decorated
    try:
        return compile_later(function)
    finally:
        settings.CACHE_DIR = before


@functools.cache
def cache_folder() -> Path | None:
    """Where compiled code is kept: beside the sources, or else in the user's cache, or nowhere."""
    here = Path(__file__).parent
    digest = hashlib.sha256(f"{numba.__version__} {mujoco.__version__}".encode())
    for name in _SOURCES:
        digest.update((here / f"{name}.py").read_bytes())
    name = f"kernel-{digest.hexdigest()[:16]}"
    user = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    return next(filter(_writable, (here / "__pycache__" / name, user / "lfr" / name)), None)


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK)


@functools.cache
def announce_compilation() -> None:
    """Say, once per process, that a compilation lies ahead, if no cache holds its result."""
    folder = cache_folder()
    if folder is None:
        where = "; no cache folder can be written (set XDG_CACHE_HOME), so every process does it"
    elif any(folder.rglob("kernel.run-*.nbi")):
        return
    else:
        where = f"; kept in {folder}"
    print(f"compiling the simulation kernel, about 20 s{where}", file=sys.stderr, flush=True)
