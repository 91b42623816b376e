"""`lfr edit delete | split | merge`: episodes taken out, apart, or together."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr edit`."""
    commands = parser.add_subparsers(metavar="what", required=True, dest="what")
    delete = commands.add_parser("delete", help="a copy without some episodes")
    delete.add_argument("dataset", type=Path)
    delete.add_argument("--episodes", required=True, metavar="0,3,7-9")
    split = commands.add_parser("split", help="parts as datasets of their own")
    split.add_argument("dataset", type=Path)
    split.add_argument("parts", nargs="+", metavar="name=0-39", help="or fractions: name=0.8")
    merge = commands.add_parser("merge", help="several datasets as one")
    merge.add_argument("datasets", type=Path, nargs="+")
    for command in (delete, split, merge):
        command.add_argument("--out", type=Path, required=True, help="a folder that is made")


def run(arguments: argparse.Namespace) -> None:
    """Write the new dataset, verified, and say what is in it.

    Raises:
        LfrError: no such episodes, datasets of different kinds, or a folder that is there.
    """
    from lfr.curation import edit

    out = arguments.out
    match arguments.what:
        case "delete":
            episodes = edit.parse_episodes(arguments.episodes, arguments.dataset)
            _say(out, edit.delete_episodes(arguments.dataset, episodes, out))
        case "split":
            splits = edit.parse_splits(arguments.parts, arguments.dataset)
            for name, counts in edit.split_episodes(arguments.dataset, splits, out).items():
                _say(out / name, counts)
        case "merge":
            _say(out, edit.merge_datasets(arguments.datasets, out))


def _say(path: Path, counts: dict[str, int]) -> None:
    videos = ", ".join(f"{counts[how]} {how}" for how in ("copied", "cut", "encoded"))
    print(f"{path}: {counts['episodes']} episodes, {counts['frames']} frames; videos: {videos}")
