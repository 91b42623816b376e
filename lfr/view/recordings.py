"""From a path to the `.rrd` files that show what is there."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from lfr.errors import DataError, LfrError
from lfr.view.collection import Collection, Overlay, collection_of, save_episodes
from lfr.view.selection import Selection

VALID = (
    "an MCAP log (.mcap) or a folder of logs, a LeRobot dataset folder, a trained policy's folder, "
    "a run's curve (.json, .csv), a recording (.rrd) or a folder of them"
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
        run: folder of the learning run that goes on, or may.
        still: nothing in them moves.
    """

    files: list[Path]
    numbers: tuple[int, ...] = ()
    collection: Collection | None = None
    run: Path | None = None
    still: bool = False


@dataclass(frozen=True)
class Wanted:
    """What is asked for beside the path.

    Attributes:
        selection: of the episodes; None is the first.
        seed: start of a policy's episode; None is a held-out one.
        mapping: folder of a transfer's G and F, for the skill view.
        skills: folder of all skill models; None is that beside the folder of all mappings.
        at: s; the viewer stands there instead of playing.
    """

    selection: Selection | None = None
    seed: int | None = None
    mapping: Path | None = None
    skills: Path | None = None
    at: float | None = None


def recordings(path: Path, folder: Path, wanted: Wanted) -> Shown:
    """The `.rrd` files that show what is at `path`, made in `folder` where there are none yet.

    Raises:
        LfrError: nothing that can be viewed.
    """
    path = existing(path)
    collection = collection_of(path)
    if collection is not None:
        return _episodes(collection, path, folder, wanted)
    if wanted.mapping is not None:
        raise LfrError(f"--mapping shows demonstrations: found {path}, expected a dataset or logs")
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

    A stage writes its outputs when it ends; `models/transfer/<run>` is until then
    `work/transfer/<run>/<fingerprint>`, of which the newest is taken.

    Raises:
        LfrError: there is neither.
    """
    if path.exists():
        return path
    parts = path.parts
    if "transfer" in parts:
        place = len(parts) - 1 - parts[::-1].index("transfer")
        run, rest = parts[place + 1 : place + 2], parts[place + 2 :]
        work = Path(os.environ.get("LFR_WORK", "work")) / "transfer"
        under = [one.joinpath(*rest) for one in work.joinpath(*run).glob("*")] if run else []
        going = [one for one in under if one.is_dir()]
        if going:
            return max(going, key=lambda one: one.stat().st_mtime)
    raise LfrError(f"cannot view {path}: it does not exist; expected {VALID}")


def _episodes(collection: Collection, path: Path, folder: Path, wanted: Wanted) -> Shown:
    if wanted.selection is None:
        numbers = [0]
    elif (number := wanted.selection.number) is not None:
        numbers = [number]
    else:
        every = collection.entries()
        numbers = [entry.index for entry in wanted.selection.apply(every)]
        if not numbers:
            raise LfrError(f"none of the {len(every)} episodes of {path} is as wanted; see --list")
        if wanted.selection.first is None and len(numbers) > MOST:
            print(f"the first {MOST} of {len(numbers)} episodes; --first N opens N", flush=True)
            numbers = numbers[:MOST]
    files = make_episodes(collection, numbers, folder, wanted)
    return Shown(files, tuple(numbers), collection, still=wanted.at is not None)


def make_episodes(
    collection: Collection, numbers: list[int], folder: Path, wanted: Wanted
) -> list[Path]:
    """The episodes of these numbers, with their skills if these are wanted."""
    if wanted.mapping is None:
        return save_episodes(collection, numbers, folder, at=wanted.at)
    episode, _ = collection.read(numbers[0])
    overlay = _skills(wanted.mapping, wanted.skills, episode.task)
    return save_episodes(collection, numbers, folder, overlay=overlay, at=wanted.at)


def _skills(mapping: Path, skills: Path | None, task: str) -> Overlay:
    from lfr.view.skills import skill_overlay
    from lfr.view.windows import load_skill_models

    return skill_overlay(load_skill_models(mapping, task, skills))


def _run(path: Path, folder: Path, seed: int | None) -> Shown:
    """A learning run's curve, the recordings it left, and an episode of its policy."""
    found = sorted(path.rglob("*.rrd"), key=lambda file: (file.name != "learning.rrd", file))
    curves = [file for file in sorted(path.rglob("curve.*")) if file.suffix in (".json", ".csv")]
    if not any(file.name == "learning.rrd" for file in found):
        found += [_curve(file, folder) for file in curves[:1]]
    if (path / "model.safetensors").is_file() and (path / "config.json").is_file():
        found.insert(0, _policy(path, folder, seed))  # the viewer turns to the first
    if not found:
        raise LfrError(f"cannot view {path}: found nothing of a dataset, a log or a run; "
                       f"expected {VALID}")  # fmt: skip
    return Shown(found, run=path)


def _curve(path: Path, folder: Path) -> Path:
    from lfr.view.curve import read_curve, save_learning

    out = folder / "learning.rrd"
    place = path.resolve()
    title = place.parent.name if place.stem == "curve" else place.stem
    save_learning(out, read_curve(path), title=title)
    return out


def _policy(path: Path, folder: Path, seed: int | None) -> Path:
    from lfr.seeds import episode_seed
    from lfr.sim.simulation import simulation
    from lfr.transfer.model import load_policy
    from lfr.view.policy import save_policy_episode
    from lfr.view.rollout import roll_out_policy

    actor, about = load_policy(path)
    for key in ("robot", "task"):
        if key not in about:
            raise DataError("a policy that does not say its arm and task",
                            file=path / "config.json", column=f"about.{key}")  # fmt: skip
    start = episode_seed("held-out", 0) if seed is None else seed
    episode, trace = roll_out_policy(actor, simulation(about["robot"], about["task"]), start)
    out = folder / f"policy-seed-{start}.rrd"
    save_policy_episode(out, episode, trace)
    return out
