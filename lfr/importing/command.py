"""`lfr import FILE --to FOLDER`: robomimic's HDF5, or bags, as a LeRobot dataset."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, get_args

from lfr.errors import DataError, ParameterError

CHOICE = ("state", "environment", "action", "quaternions", "success", "video", "simulator_states")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr import`."""
    from lfr.importing.columns import Quaternions
    from lfr.importing.features import Choice, Successes

    usual = Choice()
    parser.add_argument(
        "files", type=Path, nargs="+", metavar="file",
        help="robomimic's HDF5, with observations; or MCAP bags and folders of them",
    )  # fmt: skip
    parser.add_argument("--to", "--out", type=Path, required=True, metavar="FOLDER",
                        help="the dataset's folder, a new one")  # fmt: skip
    parser.add_argument("--mapping", type=Path, metavar="FILE",
                        help="of bags: topics and features in YAML, as `lfr columns BAG` "
                        "proposes; all other options are robomimic's")  # fmt: skip
    parser.add_argument(
        "--state", nargs="+", default=usual.state, metavar="KEY",
        help=f"observations of observation.state (default: {' '.join(usual.state)})",
    )  # fmt: skip
    parser.add_argument(
        "--environment", nargs="*", default=usual.environment, metavar="KEY",
        help="of observation.environment_state (default: object); none leaves it out",
    )  # fmt: skip
    parser.add_argument(
        "--action", default=usual.action, metavar="KEY", help="array of actions (default: actions)"
    )
    parser.add_argument(
        "--quaternions", choices=get_args(Quaternions), default=usual.quaternions,
        help="observations called _quat: two columns of the rotation matrix, or as they are",
    )  # fmt: skip
    parser.add_argument(
        "--success", choices=get_args(Successes), default=usual.success,
        help="a frame succeeds by a reward of 1, by done as recorded, or as a demonstration's last",
    )  # fmt: skip
    parser.add_argument("--no-video", dest="video", action="store_false", help="leave pictures out")
    parser.add_argument(
        "--simulator-states", action="store_true", help="keep states, as the column simulator_state"
    )
    parser.add_argument("--mask", help="only the demonstrations of this filter key")
    parser.add_argument("--robot", help="name of the arm (default: the file's)")
    parser.add_argument("--task", help="name of the task (default: the file's)")
    parser.add_argument("--instruction", help="the task in words")
    parser.add_argument("--fps", type=int, help="control steps per second (default: the file's)")


def run(arguments: argparse.Namespace) -> int:
    """Carry out `lfr import`.

    Raises:
        LfrError: a file that cannot be imported, or a folder that is not free.
    """
    from lfr.importing.bag.command import run_import
    from lfr.importing.bag.files import is_bag
    from lfr.importing.dataset import About, import_robomimic
    from lfr.importing.features import Choice

    given = vars(arguments)
    file = arguments.files[0]
    if arguments.mapping or is_bag(file):
        _refuse_options(given)
        run_import(arguments.files, arguments.mapping, arguments.to)
        return 0
    if len(arguments.files) > 1:
        raise DataError("robomimic's files are imported one by one", file=arguments.files[1])
    _refuse_lerobot(file)
    lists = {"state": tuple(arguments.state), "environment": tuple(arguments.environment)}
    choice = Choice(**{**{name: given[name] for name in CHOICE}, **lists})
    about = About(**{field.name: given[field.name] for field in fields(About)})
    counts = import_robomimic(file, arguments.to, choice, about, arguments.mask)
    print(
        f"{arguments.to}: {counts['episodes']} episodes, {counts['frames']} frames, "
        f"{counts['successes']} successful, {len(counts['cameras'])} cameras"
    )
    if counts["left_out"]:
        print(f"left out: {', '.join(counts['left_out'])}")
    return 0


def _refuse_options(given: Mapping[str, Any]) -> None:
    """Raises ParameterError when an option was given that is not for bags."""
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    of_bags = ("files", "to", "mapping", "run")
    changed = [name for name, value in given.items() if value != parser.get_default(name)]
    wrong = [name for name in changed if name not in of_bags]
    if wrong:
        options = ", ".join("--no-video" if n == "video" else f"--{n}" for n in wrong)
        raise ParameterError(f"not for bags: {options.replace('_', '-')}; the mapping says it")


def _refuse_lerobot(path: Path) -> None:
    """Raises DataError for a folder; of an old LeRobot dataset, with what converts it."""
    from lfr.data.tables import DatasetFiles

    if not path.is_dir():
        return
    if not (path / "meta" / "info.json").is_file():
        raise DataError("a folder", file=path, expected="robomimic's HDF5 file, or bags")
    version = DatasetFiles.open(path).info["codebase_version"]
    raise DataError("a LeRobot dataset already; nothing to import", file=path, found=version)
