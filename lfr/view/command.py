"""`lfr view PATH`: open an episode, a policy, a learning run or a recording in rerun."""

from __future__ import annotations

import argparse
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

from lfr.errors import DataError, LfrError

VALID = (
    "an MCAP log (.mcap) or a folder of logs, a LeRobot dataset folder, a trained policy's folder, "
    "a run's curve (.json, .csv), a recording (.rrd) or a folder of them"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr view`."""
    parser.add_argument("path", type=Path, help=VALID)
    parser.add_argument(
        "--episode", type=int, default=0, help="of a dataset or a folder of logs (default 0)"
    )
    parser.add_argument(
        "--seed", type=int, help="start of a policy's episode (default: a held-out one)"
    )
    parser.add_argument("--save", type=Path, metavar="FILE.rrd", help="write a file, open nothing")
    parser.add_argument("--web", action="store_true", help="serve the viewer to a browser")
    parser.add_argument(
        "--bind", default="127.0.0.1", help="address to listen on (default: this machine alone)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Carry out `lfr view`.

    Raises:
        LfrError: a path that cannot be viewed, or no screen to view it on.
    """
    from lfr.artifacts import write_whole
    from lfr.view.viewer import has_screen, merge, show

    path, save = arguments.path, arguments.save
    if save is not None and save.suffix != ".rrd":
        raise LfrError(f"--save writes rerun recordings: found {save}, expected a name in .rrd")
    if save is None and not arguments.web and not has_screen():
        show([], web=False)  # says so before anything is built
    with tempfile.TemporaryDirectory(prefix="lfr-view-") as folder:
        files = recordings(path, Path(folder), arguments.episode, arguments.seed)
        if save is None:
            live = any(file.suffix == ".rrd" and file.parent != Path(folder) for file in files)
            show(files, web=arguments.web, address=arguments.bind, follow=live)
            return 0
        with write_whole(save) as partial:
            if len(files) == 1:
                shutil.copyfile(files[0], partial)
            else:
                merge(files, partial)
    print(save)
    return 0


def recordings(path: Path, folder: Path, episode: int = 0, seed: int | None = None) -> list[Path]:
    """The `.rrd` files that show what is at `path`, made in `folder` where there are none yet.

    Raises:
        LfrError: nothing that can be viewed.
    """
    from lfr.view.dataset import is_dataset

    if not path.exists():
        raise LfrError(f"cannot view {path}: it does not exist; expected {VALID}")
    if path.is_file():
        makers: dict[str, Callable[[], list[Path]]] = {
            ".rrd": lambda: [path],
            ".mcap": lambda: [_log(path, folder)],
            ".json": lambda: [_curve(path, folder)],
            ".csv": lambda: [_curve(path, folder)],
        }
        if path.suffix not in makers:
            raise LfrError(f"cannot view {path}: found a {path.suffix or 'plain'} file; "
                           f"expected {VALID}")  # fmt: skip
        return makers[path.suffix]()
    if is_dataset(path):
        return [_dataset_episode(path, episode, folder)]
    if list(path.glob("*.mcap")):
        from lfr.data.log_reader import list_logs

        logs = list_logs(path)
        if not 0 <= episode < len(logs):
            raise DataError("no such episode", file=path, episode=episode,
                            expected=f"0 to {len(logs) - 1}")  # fmt: skip
        return [_log(logs[episode], folder)]
    return _run(path, folder, seed)


def _run(path: Path, folder: Path, seed: int | None) -> list[Path]:
    """A learning run's curve, the recordings it left, and an episode of its policy."""
    found = sorted(path.rglob("*.rrd"))
    curves = [file for file in sorted(path.rglob("curve.*")) if file.suffix in (".json", ".csv")]
    if not any(file.name == "learning.rrd" for file in found):
        found += [_curve(file, folder) for file in curves[:1]]
    if (path / "model.safetensors").is_file() and (path / "config.json").is_file():
        found.append(_policy(path, folder, seed))
    if not found:
        raise LfrError(f"cannot view {path}: found nothing of a dataset, a log or a run; "
                       f"expected {VALID}")  # fmt: skip
    return found


def _log(path: Path, folder: Path) -> Path:
    from lfr.data.log_reader import read_log
    from lfr.view.episode import save_episode
    from lfr.view.motion import poses_of

    episode = read_log(path)
    out = folder / f"{path.stem}.rrd"
    save_episode(out, episode, poses_of(episode, path))
    return out


def _dataset_episode(path: Path, index: int, folder: Path) -> Path:
    from lfr.view.dataset import find_log, read_episode
    from lfr.view.episode import save_episode
    from lfr.view.motion import poses_of

    episode = read_episode(path, index)
    out = folder / f"episode-{index:06d}.rrd"
    save_episode(out, episode, poses_of(episode, find_log(path, episode)))
    return out


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
