"""`lfr view PATH`: episodes, a policy, a learning run or a recording, listed or opened in rerun."""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from lfr.errors import LfrError
from lfr.view.recordings import (
    MOST,
    VALID,
    Shown,
    Wanted,
    existing,
    going,
    make_episodes,
    recordings,
    with_findings,
)
from lfr.view.selection import ORDERS, Ranges, Selection

if TYPE_CHECKING:
    from lfr.view.findings import Findings
    from lfr.view.viewer import Viewer

VERIFY = ""  # of --findings: no file, so that the dataset is looked at now


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr view`."""
    parser.add_argument("path", type=Path, help=VALID)
    parser.add_argument("--list", action="store_true", help="print the episodes, open nothing")
    parser.add_argument("--revision", help="of a dataset on the Hub: a branch, tag or commit")

    chosen = parser.add_argument_group("which episodes, of a dataset or a folder of logs")
    chosen.add_argument(
        "--episode", "--episodes", dest="episodes", type=_ranges, metavar="N",
        help="by number, as in 3 or 3,5-9 (default: the first)",
    )  # fmt: skip
    chosen.add_argument(
        "--seed", type=_ranges, metavar="N",
        help="by seed, likewise; of a policy, its start (default: a held-out one)",
    )  # fmt: skip
    chosen.add_argument(
        "--length", type=_ranges, metavar="N", help="by frames, as in 40-80 or 120-"
    )
    outcome = chosen.add_mutually_exclusive_group()
    outcome.add_argument("--failed", action="store_true", help="those without success")
    outcome.add_argument("--succeeded", action="store_true", help="those with success")
    chosen.add_argument(
        "--sort",
        choices=ORDERS,
        help="longest, highest reward, or lowest number, seed or score first",
    )
    chosen.add_argument("--reverse", action="store_true", help="turn the order round")
    chosen.add_argument(
        "--first", type=_count, metavar="N", help=f"so many of them (default: {MOST} to open)"
    )

    shown = parser.add_argument_group("what is shown")
    shown.add_argument(
        "--side-by-side", metavar="PATH[:N]",
        help="side by side with another: an episode of a dataset or log (default: of the same "
        "seed), a policy or a recording; N alone is another of this dataset",
    )  # fmt: skip
    shown.add_argument(
        "--mapping", type=Path, metavar="FOLDER",
        help="of a transfer (models/mapping/s1-panda-lift): each window's latent, priors and G",
    )  # fmt: skip
    shown.add_argument(
        "--skills", type=Path, metavar="FOLDER",
        help="of all skill models (default: beside that of all mappings)",
    )  # fmt: skip
    shown.add_argument(
        "--policy", type=Path, metavar="FOLDER",
        help="in LeRobot's format: what it would have done at each frame, beside the actions",
    )  # fmt: skip
    shown.add_argument(
        "--findings", nargs="?", const=VERIFY, metavar="FILE.json",
        help="of a dataset, worst episodes first: what lfr verify finds, or printed with --json",
    )  # fmt: skip
    shown.add_argument("--at", type=float, metavar="SECONDS", help="stand there, do not play")

    where = parser.add_argument_group("where")
    target = where.add_mutually_exclusive_group()
    target.add_argument("--save", type=Path, metavar="FILE.rrd", help="write it, open nothing")
    target.add_argument("--screenshot", type=Path, metavar="FILE.png", help="write a picture")
    target.add_argument("--web", action="store_true", help="serve the viewer to a browser")
    where.add_argument("--size", type=_size, metavar="WxH", help="of the picture, in pixels")
    where.add_argument(
        "--bind", default="127.0.0.1", help="address to listen on (default: this machine alone)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Carry out `lfr view`.

    Raises:
        LfrError: a path that cannot be viewed, or no screen to view it on.
    """
    from lfr.data.opening import opened

    if not arguments.list:
        _check_names(arguments)
        _check_screen(arguments)
    with opened(going(arguments.path), arguments.revision) as path:
        there = argparse.Namespace(**{**vars(arguments), "path": path})
        return _list(there) if arguments.list else _open(there)


def _open(arguments: argparse.Namespace) -> int:
    from lfr.view.viewer import show

    with tempfile.TemporaryDirectory(prefix="lfr-view-") as name:
        folder, wanted = Path(name), _wanted(arguments)
        if arguments.side_by_side is not None:
            shown = _side_by_side(arguments, folder, wanted)
        else:
            shown = recordings(arguments.path, folder, wanted)
        if not _opens(arguments):
            return _write(arguments, shown)
        show(
            shown.files, web=arguments.web, address=arguments.bind,
            follow=shown.learning is not None,
            attend=lambda viewer: _attend(viewer, shown, folder, wanted),
        )  # fmt: skip
    return 0


def _list(arguments: argparse.Namespace) -> int:
    from lfr.view.collection import collection_of
    from lfr.view.listing import table

    path = existing(arguments.path)
    collection = collection_of(path)
    if collection is None:
        raise LfrError(f"{path} has no episodes to list; expected a dataset or logs")
    _check_names(arguments)
    entries = with_findings(collection, _findings(arguments)).entries()
    kept = (_selection(arguments) or Selection()).apply(entries)
    try:
        print(table(kept, len(entries), collection.fps), flush=True)
    except BrokenPipeError:  # `| head` has seen enough
        sys.stderr.close()
    return 0


def _write(arguments: argparse.Namespace, shown: Shown) -> int:
    from lfr.artifacts import write_whole
    from lfr.view.screenshot import SIZE, take_screenshot
    from lfr.view.viewer import merge

    if shown.learning is not None:
        shown.learning.close()
    if arguments.screenshot is not None:
        size = arguments.size or SIZE
        take_screenshot(shown.files, arguments.screenshot, size, shown.still)
        print(arguments.screenshot)
        return 0
    with write_whole(arguments.save) as partial:
        if len(shown.files) == 1:
            shutil.copyfile(shown.files[0], partial)
        else:
            merge(shown.files, partial)
    print(arguments.save)
    return 0


def _side_by_side(arguments: argparse.Namespace, folder: Path, wanted: Wanted) -> Shown:
    from lfr.view.pairing import save_pair

    out = folder / "side-by-side.rrd"
    save_pair(out, arguments.path, arguments.side_by_side, folder, wanted)
    return Shown([out], still=wanted.at is not None)


def _attend(viewer: Viewer, shown: Shown, folder: Path, wanted: Wanted) -> None:
    """What is done while the viewer is open."""
    from lfr.view.interactive import add_recordings, step_through

    collection = shown.collection
    if shown.learning is not None:
        add_recordings(viewer, shown.learning.look)
    elif collection is not None and collection.several and _is_terminal():
        # Next is the next that was asked for: of the failed ones, of the longest first.
        like = replace(wanted.selection or Selection(), episodes=None, first=None)
        step_through(
            viewer,
            lambda: [entry.index for entry in like.apply(collection.entries())],
            shown.numbers[0],
            lambda number: make_episodes(collection, [number], folder, wanted)[0],
        )


def _is_terminal() -> bool:
    return sys.stdin is not None and sys.stdin.isatty()


def _wanted(arguments: argparse.Namespace) -> Wanted:
    """A seed chooses among episodes where there are any, and is a policy's start elsewhere."""
    from lfr.view.collection import is_collection

    if is_collection(existing(arguments.path)):
        selection, seed = _selection(arguments), None
    else:
        without = argparse.Namespace(**{**vars(arguments), "seed": None})
        selection, seed = _selection(without), _start(arguments.seed)
    findings = _findings(arguments)
    if findings is not None and arguments.episodes is None:
        selection = replace(
            selection or Selection(), findings=True, order=arguments.sort or "score"
        )
    return Wanted(
        selection, seed, arguments.mapping, arguments.skills, arguments.policy, arguments.at,
        findings,
    )  # fmt: skip


def _findings(arguments: argparse.Namespace) -> Findings | None:
    if arguments.findings is None:
        return None
    from lfr.view.findings import findings_of

    file = None if arguments.findings == VERIFY else Path(arguments.findings)
    return findings_of(existing(arguments.path), file)


def _selection(arguments: argparse.Namespace) -> Selection | None:
    """What the arguments choose; None where they choose nothing."""
    selection = Selection(
        episodes=arguments.episodes,
        seeds=arguments.seed,
        lengths=arguments.length,
        success=False if arguments.failed else True if arguments.succeeded else None,
        order=arguments.sort or "episode",
        reverse=arguments.reverse,
        first=arguments.first,
    )
    return None if selection == Selection() else selection


def _start(seeds: Ranges | None) -> int | None:
    if seeds is None:
        return None
    if not seeds.text.isdecimal():
        raise LfrError(f"a policy starts from one seed: found {seeds.text}, expected a number")
    return int(seeds.text)


def _check_names(arguments: argparse.Namespace) -> None:
    if arguments.skills is not None and arguments.mapping is None:
        raise LfrError("--skills says where skill models lie; --mapping says of which transfer")
    if arguments.sort == "score" and arguments.findings is None:
        raise LfrError("--sort score needs --findings, by which episodes are scored")
    if arguments.findings is not None and arguments.side_by_side is not None:
        raise LfrError("--findings are shown of one episode at a time, not side by side")
    if arguments.policy is not None and arguments.side_by_side is not None:
        raise LfrError("--policy is shown of one episode at a time, not side by side")
    if arguments.save is not None and arguments.save.suffix != ".rrd":
        raise LfrError(f"--save writes rerun recordings: found {arguments.save}, "
                       "expected a name in .rrd")  # fmt: skip
    if arguments.screenshot is not None and arguments.screenshot.suffix != ".png":
        raise LfrError(f"--screenshot writes PNG: found {arguments.screenshot}, "
                       "expected a name in .png")  # fmt: skip


def _check_screen(arguments: argparse.Namespace) -> None:
    """Says that there is none before anything is fetched or built."""
    from lfr.view.viewer import has_screen, show

    if _opens(arguments) and not arguments.web and not has_screen():
        show([], web=False)


def _opens(arguments: argparse.Namespace) -> bool:
    return arguments.save is None and arguments.screenshot is None


def _ranges(text: str) -> Ranges:
    try:
        return Ranges.parse(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a number from 1 on")
    return int(text)


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal()) or "0" in (width, height):
        raise argparse.ArgumentTypeError(f"found {text!r}, expected WIDTHxHEIGHT as in 1600x1000")
    return int(width), int(height)
