"""`lfr card`: write the cards of datasets and models from their files and the stages' results."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from lfr.errors import LfrError

DATASETS, MODELS = Path("dataset_cards"), Path("model_cards")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr card`."""
    parser.add_argument(
        "paths", type=Path, nargs="*", metavar="PATH",
        help="datasets and folders of models (default: all under data/lerobot and models)",
    )  # fmt: skip
    parser.add_argument(
        "--results", type=Path, default=Path("results"),
        help="what the stages noted (default: results)",
    )  # fmt: skip
    parser.add_argument(
        "--to", type=Path, default=Path(),
        help=f"where {DATASETS} and {MODELS} are (default: here)",
    )  # fmt: skip
    parser.add_argument(
        "--check", action="store_true", help="write nothing; exit code 1 if a card is out of date"
    )


def run(arguments: argparse.Namespace) -> int:
    """Carry out `lfr card`.

    Raises:
        LfrError: nothing to describe, or what is there is no dataset and no models.
    """
    paths = arguments.paths or everything(Path("data/lerobot"), Path("models"))
    if not paths:
        raise LfrError("no datasets in data/lerobot and no models in models; run `dvc repro`")
    stale = 0
    for path in paths:
        for name, content in cards(path, arguments.results).items():
            file = arguments.to / name
            if file.is_file() and file.read_bytes() == content:
                continue
            stale += 1
            if arguments.check:
                print(f"{file}: out of date; run `lfr card {path}`", file=sys.stderr)
                continue
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
            print(file)
    return int(arguments.check and stale > 0)


def everything(datasets: Path, models: Path) -> list[Path]:
    """All datasets and all folders of models that the main job has made.

    The models of studies, beside them, are many, and described by their reports.
    """
    from lfr.hub.model_facts import STAGES

    stages = {*STAGES.values(), "external-skills"}
    made = {folder for stage in stages for folder in models.glob(f"{stage}/[!.]*/")}
    return [*sorted(datasets.glob("[!.]*/")), *sorted(made)]


def cards(path: Path, results: Path) -> dict[str, bytes]:
    """A dataset's card and picture, or a card of models, by where they lie in the project."""
    from lfr.hub.publication import dataset_card_files, is_dataset, model_card_text

    if not is_dataset(path):
        title, text = model_card_text(path, results)
        return {(MODELS / f"{title}.md").as_posix(): text.encode()}
    text, pictures = dataset_card_files(path, results)
    files = {f"{path.resolve().name}.md": text.encode(), **pictures}
    return {(DATASETS / name).as_posix(): content for name, content in files.items()}
