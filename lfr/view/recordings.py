"""From a path to the `.rrd` files that show what is there."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from lfr.errors import LfrError
from lfr.view.collection import (
    EPISODE_ALONE,
    Collection,
    Overlay,
    collection_of,
    save_episodes,
)
from lfr.view.selection import Selection

if TYPE_CHECKING:
    from lfr.view.findings import Findings
    from lfr.view.learning import RunRecordings

VALID = (
    "an MCAP log (.mcap) or a folder of logs, a LeRobot dataset's folder or name on the Hub "
    "(owner/name), a trained policy's folder, a run's curve (.json, .csv), a recording (.rrd) or a "
    "folder of them"
)
MOST = 20
"""Episodes opened at once where no number is asked for: the arm's meshes make each some 8 MB."""


@dataclass(frozen=True)
class Shown:
    """What is to be opened.

    Attributes:
        files: `.rrd` files.
        numbers: of the episodes, where they are of a collection.
        collection: that they are of.
        run: whether they are of a policy or of learning runs.
        learning: the recordings of learning runs, where these may go on.
        still: nothing in them moves.
    """

    files: list[Path]
    numbers: tuple[int, ...] = ()
    collection: Collection | None = None
    run: bool = False
    learning: RunRecordings | None = None
    still: bool = False


@dataclass(frozen=True)
class Wanted:
    """What is asked for beside the path.

    Attributes:
        selection: of the episodes; None is the first.
        seed: start of a policy's episode; None is a held-out one.
        mapping: folder of a transfer's G and F, for the skill view.
        skills: folder of all skill models; None is that beside the folder of all mappings.
        policy: folder of a policy whose actions are shown beside the recorded ones.
        at: s; the viewer stands there instead of playing.
        findings: of a dataset's episodes, shown with them.
    """

    selection: Selection | None = None
    seed: int | None = None
    mapping: Path | None = None
    skills: Path | None = None
    policy: Path | None = None
    at: float | None = None
    findings: Findings | None = None


def recordings(path: Path, folder: Path, wanted: Wanted) -> Shown:
    """The `.rrd` files that show what is at `path`, made in `folder` where there are none yet.

    Raises:
        LfrError: nothing that can be viewed.
    """
    path = existing(path)
    collection = collection_of(path)
    if collection is not None:
        return _episodes(with_findings(collection, wanted.findings), path, folder, wanted)
    for option, value in (("--mapping", wanted.mapping), ("--policy", wanted.policy)):
        if value is not None:
            raise LfrError(
                f"{option} shows demonstrations: found {path}, expected a dataset or logs"
            )
    if wanted.selection is not None:
        raise LfrError(f"{path} has no episodes to choose from; expected a dataset or logs")
    if path.is_file():
        makers: dict[str, Callable[[], Path]] = {
            ".rrd": lambda: path,
            ".json": lambda: _curve(path, folder),
            ".csv": lambda: _curve(path, folder),
        }
        if path.suffix not in makers:
            raise LfrError(f"cannot view {path}: found a {path.suffix or 'plain'} file; "
                           f"expected {VALID}")  # fmt: skip
        return Shown([makers[path.suffix]()], still=path.suffix != ".rrd")
    return _run(path, folder, wanted.seed)


def existing(path: Path) -> Path:
    """The path, or where a run that goes on keeps what it will leave there.

    Raises:
        LfrError: there is neither.
    """
    if (found := going(path)).exists():
        return found
    raise LfrError(f"cannot view {path}: it does not exist; expected {VALID}")


def going(path: Path) -> Path:
    """Where a run that goes on keeps what it will leave at the path; else the path itself.

    A stage writes its outputs when it ends; `models/transfer/<run>` is until then
    `work/transfer/<run>/<fingerprint>`, of which the newest is taken.
    """
    parts = path.parts
    if path.exists() or "transfer" not in parts:
        return path
    place = len(parts) - 1 - parts[::-1].index("transfer")
    run, rest = parts[place + 1 : place + 2], parts[place + 2 :]
    work = Path(os.environ.get("LFR_WORK", "work")) / "transfer"
    under = [one.joinpath(*rest) for one in work.joinpath(*run).glob("*")] if run else []
    return max((one for one in under if one.is_dir()), default=path,
               key=lambda one: one.stat().st_mtime)  # fmt: skip


def _episodes(collection: Collection, path: Path, folder: Path, wanted: Wanted) -> Shown:
    if wanted.selection is None:
        numbers = [0]
    elif (number := wanted.selection.number) is not None:
        numbers = [number]
    else:
        every = collection.entries()
        numbers = [entry.index for entry in wanted.selection.apply(every)]
        if not numbers:
            if wanted.selection == Selection(findings=True, order="score"):
                raise LfrError(f"nothing is found in any of the {len(every)} episodes of {path}")
            raise LfrError(f"none of the {len(every)} episodes of {path} is as wanted; see --list")
        if wanted.selection.first is None and len(numbers) > MOST:
            print(f"the first {MOST} of {len(numbers)} episodes; --first N opens N", flush=True)
            numbers = numbers[:MOST]
    files = make_episodes(collection, numbers, folder, wanted)
    return Shown(files, tuple(numbers), collection, still=wanted.at is not None)


def make_episodes(
    collection: Collection, numbers: list[int], folder: Path, wanted: Wanted
) -> list[Path]:
    """The episodes of these numbers, with their skills and findings if these are wanted."""
    overlay = EPISODE_ALONE
    if wanted.mapping is not None:
        episode, _ = collection.read(numbers[0])
        overlay = _skills(wanted.mapping, wanted.skills, episode.task)
    if wanted.policy is not None:
        from lfr.view.open_loop import policy_overlay

        overlay = policy_overlay(wanted.policy, overlay)
    if wanted.findings is not None:
        from lfr.view.findings import findings_overlay

        overlay = findings_overlay(wanted.findings, overlay)
    return save_episodes(collection, numbers, folder, overlay=overlay, at=wanted.at)


def with_findings(collection: Collection, findings: Findings | None) -> Collection:
    """The collection, its entries marked with what is found."""
    if findings is None:
        return collection
    return replace(collection, entries=lambda: findings.marked(collection.entries()))


def _skills(mapping: Path, skills: Path | None, task: str) -> Overlay:
    from lfr.view.skills import skill_overlay
    from lfr.view.windows import load_skill_models

    return skill_overlay(load_skill_models(mapping, task, skills))


def _run(path: Path, folder: Path, seed: int | None) -> Shown:
    """An episode of a policy, and the recordings of its learning: as they are, or made."""
    from lfr.view.learning import RunRecordings

    attempt = [save_policy(path, folder, seed)] if is_policy(path) else []  # the viewer turns to it
    made, learning = _sibling(path, "recordings"), _sibling(path, "models/learning")
    for place in (path, made):
        if kept := sorted(place.rglob("*.rrd"), key=lambda f: (f.name != "learning.rrd", f)):
            return Shown([*attempt, *kept], run=True)
    runs = RunRecordings(learning, folder)
    found = [*attempt, *runs.look()]
    if found == attempt and (curves := sorted(path.rglob("curve.json"))):
        found.append(_curve(curves[0], folder))
    if not found:
        raise LfrError(f"cannot view {path}: found nothing of a dataset, a log or a run; "
                       f"expected {VALID}")  # fmt: skip
    return Shown(found, run=True, learning=runs)


def _sibling(path: Path, kind: str) -> Path:
    """Where the pipeline keeps another kind of thing of the same runs; else the path itself.

    Of `models/transfer/<run>` and what is below it, that is `<kind>/<run>` beside `models`.
    """
    whole = path.resolve()
    for folder in whole.parents:
        if folder.parts[-2:] in (("models", "transfer"), ("models", "learning")):
            there = folder.parents[1] / kind / whole.relative_to(folder)
            return there if there.is_dir() else path
    return path


def _curve(path: Path, folder: Path) -> Path:
    from lfr.view.curve import read_curve, save_learning

    out = folder / "learning.rrd"
    place = path.resolve()
    title = place.parent.name if place.stem == "curve" else place.stem
    save_learning(out, read_curve(path), title=title)
    return out


def is_policy(path: Path) -> bool:
    """Whether a folder holds a model, and should hold a policy."""
    return (path / "model.safetensors").is_file() and (path / "config.json").is_file()


def save_policy(path: Path, folder: Path, seed: int | None) -> Path:
    """An episode of the policy at `path`, in `folder`; from a held-out start by default.

    Raises:
        DataError: no transferred policy, or one that does not say its arm and task.
    """
    from lfr.seeds import episode_seed
    from lfr.view.learning import save_attempt

    start = episode_seed("held-out", 0) if seed is None else seed
    out = folder / f"policy-seed-{start}.rrd"
    save_attempt(path, out, start)
    return out
