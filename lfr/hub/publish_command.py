"""`lfr publish PATH`: a dataset or models to the Hugging Face Hub, or to a folder."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from lfr.errors import LfrError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr publish`."""
    parser.add_argument("path", type=Path, help="a LeRobot dataset's folder, or one of models")
    to = parser.add_mutually_exclusive_group(required=True)
    to.add_argument("--repo", metavar="OWNER/NAME", help="repository on the Hub")
    to.add_argument("--to", type=Path, metavar="FOLDER", help="a folder instead of the Hub")
    parser.add_argument(
        "--with-logs", type=Path, metavar="DIR", help="publish the MCAP logs in DIR beside the data"
    )
    parser.add_argument("--private", action="store_true", help="a repository that only you see")
    parser.add_argument(
        "--tag", action="append", default=[], help="a further tag of this revision; repeatable"
    )
    parser.add_argument(
        "--move-tags", action="store_true", help="let a tag that is there name this revision"
    )
    parser.add_argument("--card", type=Path, help="a card of your own (default: generated)")
    parser.add_argument(
        "--license", metavar="ID",
        help="for the generated card, as the Hub names it, e.g. cc-by-4.0 (default: apache-2.0 for "
        "what this project made, none for data by others)",
    )  # fmt: skip
    parser.add_argument(
        "--results", type=Path, default=Path("results"),
        help="what the stages noted, quoted by the card (default: results)",
    )  # fmt: skip
    parser.add_argument(
        "--dry-run", action="store_true", help="check, list files and sizes, publish nothing"
    )


def run(arguments: argparse.Namespace) -> int:
    """Carry out `lfr publish`.

    Raises:
        LfrError: what is there is faulty, or could not be published.
    """
    from lfr.hub.publication import publication

    repo, folder = arguments.repo, arguments.to
    if repo is not None and len(repo.split("/")) != 2:
        raise LfrError(f"found the repository {repo!r}; expected OWNER/NAME")
    if folder is not None and (arguments.private or arguments.tag or arguments.move_tags):
        raise LfrError("a folder has no tags and is as private as you make it; leave them out")
    if arguments.card is not None and arguments.license is not None:
        raise LfrError("--license is for the generated card; put it into the header of your own")
    if arguments.card is not None and not arguments.card.is_file():
        raise LfrError(f"found no card at {arguments.card}")
    planned = publication(
        arguments.path,
        repo_id=repo,
        results=arguments.results,
        logs=arguments.with_logs,
        card=arguments.card,
        license=arguments.license,
        tags=tuple(arguments.tag),
    )
    if arguments.card is None and not arguments.results.is_dir():
        print(
            f"lfr: no folder {arguments.results} here: the card cannot say how this was made",
            file=sys.stderr,
        )
    if not planned.licensed:
        print(
            "lfr: the card names no licence; --license, or a card of your own, can", file=sys.stderr
        )
    sizes = planned.sizes
    if arguments.dry_run:
        for path, size in sorted(sizes.items()):
            print(f"{size:>12,}  {path}")
    total = f"{len(sizes)} files, {sum(sizes.values()) / 1e6:.1f} MB"
    if arguments.dry_run:
        tags = f", tagged {', '.join(planned.tags)}" if repo and planned.tags else ""
        print(f"{total}{tags}: would go to {repo or folder}")
        return 0
    if folder is not None:
        from lfr.hub.folder import publish_to_folder

        publish_to_folder(planned, folder)
        print(f"{total}: {folder}")
        return 0
    from lfr.hub.upload import publish_to_hub

    assert repo is not None  # argparse asks for the one or the other

    url, commit = publish_to_hub(
        planned, repo, private=arguments.private or None, move_tags=arguments.move_tags
    )
    print(f"{total}: {url} at {commit}")
    return 0
