"""What is kept on disk: written whole or not at all, named by fingerprints, never pickled."""

from __future__ import annotations

import ast
import contextlib
import dataclasses
import hashlib
import json
import os
import platform
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lfr.errors import DataError

if TYPE_CHECKING:
    from torch import Tensor

PACKAGES = ("lerobot", "robosuite", "mujoco", "numpy", "numba", "torch", "dvc", "rerun-sdk",
            "foxglove-sdk")  # fmt: skip
SOURCES = ("lfr", "pipeline", "params.yaml", "dvc.yaml", "requirements.lock")
DEEPEST = 64  # levels of JSON


@contextlib.contextmanager
def write_whole(final: Path) -> Iterator[Path]:
    """A place beside ``final`` to write a file or a folder to, renamed onto it at the end.

    What stood under the final name stays until then. If the body raises, the unfinished place is
    removed; if the process is killed, it stays as ``.partial-<name>`` until the next attempt.

    Args:
        final: the file's or folder's name. Its parents are made.

    Yields:
        The path to write to, with the suffix of ``final``; nothing is there yet.
    """
    final = Path(final)
    final.parent.mkdir(parents=True, exist_ok=True)
    partial, before = (final.with_name(f".{word}-{final.name}") for word in ("partial", "before"))
    _remove(partial)
    if before.exists():  # killed between two renames
        _remove(before) if final.exists() else before.rename(final)
    try:
        yield partial
        for path in [partial, *partial.rglob("*")]:
            _sync(path)
        if final.is_dir() and not final.is_symlink():  # a folder cannot be renamed onto a folder
            _replace_folder(final, partial, before)
        else:
            partial.replace(final)
        _sync(final.parent)
    except BaseException:
        _remove(partial)
        raise


def _replace_folder(final: Path, partial: Path, before: Path) -> None:
    """Let ``partial`` take the place of ``final``, at once where the system can."""
    if _exchange(partial, final):
        _remove(partial)  # which is what stood there
        return
    final.rename(before)
    try:
        partial.rename(final)
    except BaseException:
        before.rename(final)
        raise
    _remove(before)


def _exchange(first: Path, second: Path) -> bool:
    """Swap two names in one step, by Linux's renameat2; False where it, or the disk, has it not."""
    import ctypes

    here, exchange = -100, 2  # AT_FDCWD, RENAME_EXCHANGE
    try:
        renameat2 = ctypes.CDLL(None, use_errno=True).renameat2
    except (AttributeError, OSError, TypeError):
        return False
    return renameat2(here, os.fsencode(first), here, os.fsencode(second), exchange) == 0


def write_json(path: Path, content: object, *, allow_nan: bool = False) -> None:
    """Write JSON whole, indented and with a final newline; NaN is refused (ValueError)."""
    text = json.dumps(as_json(content), indent=2, ensure_ascii=False, allow_nan=allow_nan)
    with write_whole(path) as partial:
        partial.write_text(text + "\n", encoding="utf-8")


def read_json(path: Path) -> Any:
    """What a JSON file holds.

    Raises:
        DataError: the file is missing or no JSON.
    """
    try:
        return parse_json(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise DataError("the file is missing", file=path) from None
    except ValueError as error:
        raise DataError("the file is cut off or no JSON", file=path, found=error) from None


def parse_json(text: str) -> Any:
    """What a text in JSON says.

    Raises:
        ValueError: it is no JSON, or nested more than DEEPEST deep, where whoever reads it would
            reach the end of Python's stack.
    """
    try:
        content = json.loads(text)
    except RecursionError:
        raise ValueError(f"nested more than {DEEPEST} deep") from None
    if text.count("[") + text.count("{") <= DEEPEST:
        return content
    level = [content]
    for _ in range(DEEPEST):
        inside = (one.values() if isinstance(one, dict) else one for one in level)
        level = [one for each in inside for one in each if isinstance(one, dict | list)]
        if not level:
            return content
    raise ValueError(f"nested more than {DEEPEST} deep")


def as_json(value: object) -> Any:
    """``value`` in JSON's types: dataclasses as mappings, tuples as lists, paths as text.

    Raises:
        TypeError: a value that JSON cannot hold.
    """
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Path):
        return value.as_posix()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = dataclasses.fields(value)
        return {field.name: as_json(getattr(value, field.name)) for field in fields}
    if isinstance(value, Mapping):
        return {str(key): as_json(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [as_json(item) for item in value]
    if isinstance(value, set | frozenset):
        return sorted(as_json(item) for item in value)
    if tolist := getattr(value, "tolist", None):  # NumPy arrays and scalars, tensors
        return tolist()
    raise TypeError(f"{type(value).__name__} is not a value that JSON can hold: {value!r}")


def fingerprint(*parts: object) -> str:
    """16 hexadecimal digits that change when any of the parts changes.

    A part is anything `as_json` takes; a Path that is itself a part counts by its content
    (`file_hash`), one inside a part by its name.
    """
    contents = [file_hash(part) if isinstance(part, Path) else as_json(part) for part in parts]
    text = json.dumps(contents, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def file_hash(path: Path) -> str:
    """SHA-256 of a file, or of a folder's file names and contents (without ``__pycache__``).

    Raises:
        DataError: there is nothing at this path.
    """
    if path.is_file():
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    if not path.is_dir():
        raise DataError("the file is missing", file=path)
    digest = hashlib.sha256()
    for file in files_below(path):
        if file.is_file() and "__pycache__" not in file.parts:
            digest.update(f"{file.relative_to(path).as_posix()} {file_hash(file)}\n".encode())
    return digest.hexdigest()


def files_below(folder: Path, suffix: str = "") -> list[Path]:
    """The files of a kind in a folder and below, in order; links to folders are followed."""
    found: list[Path] = []
    seen: set[str] = set()  # folders, so that a link to one above does not lead round and round
    for place, folders, files in os.walk(folder, followlinks=True):
        real = os.path.realpath(place)
        if real in seen:
            folders.clear()
            continue
        seen.add(real)
        found += [Path(place) / name for name in files if name.endswith(suffix)]
    return sorted(found)


def code_fingerprint(*packages: str) -> str:
    """A fingerprint of the sources of packages or modules such as "lfr.skills".

    It is taken of the syntax trees, so comments and layout do not count and a checkpoint
    outlives them.

    Raises:
        DataError: there is no such package.
    """
    root = Path(__file__).parent.parent
    trees: dict[str, str] = {}
    for package in packages:
        folder = root.joinpath(*package.split("."))
        files = sorted(folder.rglob("*.py")) if folder.is_dir() else [folder.with_suffix(".py")]
        for file in files:
            if not file.is_file():
                raise DataError("no such package of lfr", file=file)
            tree = ast.dump(ast.parse(file.read_text(encoding="utf-8")))
            trees[file.relative_to(root).as_posix()] = tree
    return fingerprint(trees)


def work_folder(stage: str, print: str) -> Path:
    """``work/<stage>/<print>``, made if missing: where a stage's unfinished work is kept.

    git and DVC ignore it, so an interrupted stage finds it again; the fingerprint ``print`` names
    all that the work depends on. ``LFR_WORK`` in the environment puts it elsewhere.
    """
    folder = Path(os.environ.get("LFR_WORK", "work")) / stage / print
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def save_model(folder: Path, config: dict[str, Any], tensors: Mapping[str, Tensor]) -> None:
    """A model as a folder of ``config.json`` and ``model.safetensors``, written whole."""
    from safetensors.torch import save_file

    with write_whole(folder) as partial:
        partial.mkdir()
        write_json(partial / "config.json", config)
        # clone: safetensors refuses tensors that share memory
        contents = {name: t.detach().cpu().contiguous().clone() for name, t in tensors.items()}
        save_file(contents, partial / "model.safetensors")


def load_model(folder: Path) -> tuple[dict[str, Any], dict[str, Tensor]]:
    """The configuration and the tensors of a model saved by `save_model`, on the CPU.

    Raises:
        DataError: a file is missing or cut off.
    """
    from safetensors import SafetensorError
    from safetensors.torch import load_file

    config = read_json(folder / "config.json")
    file = folder / "model.safetensors"
    try:
        return config, load_file(file)
    except FileNotFoundError:
        raise DataError("the file is missing", file=file) from None
    except SafetensorError as error:
        raise DataError("the file is cut off or no safetensors", file=file, found=error) from None


def provenance() -> dict[str, Any]:
    """What made a result: the git revision, whether the sources differ from it, versions, and the
    processor, of which the last digits depend.
    """
    return {
        "revision": _git("rev-parse", "HEAD"),
        "modified": bool(_git("status", "--porcelain", "--untracked-files=no", "--", *SOURCES)),
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "packages": {name: _version(name) for name in PACKAGES},
    }


def _processor() -> str | None:
    """The processor's name; None where the system does not say it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or None
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, None) or platform.processor() or None


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:  # a benchmark can do without most of them
        return None


def _git(*arguments: str) -> str | None:
    """What a git command says about lfr's checkout; None without git or outside a checkout."""
    command = ["git", "-C", str(Path(__file__).parent.parent), *arguments]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return done.stdout.strip()


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _sync(path: Path) -> None:
    """Have the disk hold what was written, so that a rename never shows a file of zeros."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
