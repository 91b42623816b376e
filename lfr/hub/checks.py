"""What must hold before anything is published: the one place that says what is refused."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from lfr.artifacts import file_hash
from lfr.curation.checks.logs import episode_logs, has_logs
from lfr.curation.contents import EPISODES, Contents
from lfr.curation.finding import as_error, readable
from lfr.curation.verify import verify_dataset
from lfr.errors import DataError


def refuse_faulty_dataset(path: Path) -> None:
    """Hold a dataset to what `lfr verify` asks of it; warnings do not count.

    Raises:
        DataError: the first thing that is wrong, with its place.
    """
    errors = verify_dataset(path).errors
    if errors:
        all_of_them = f"{len(errors)} error{'s' if len(errors) > 1 else ''}; `lfr verify` lists all"
        message = f"{errors[0].check}: {errors[0].message} ({all_of_them})"
        raise as_error(path, errors[0], message)


def refuse_faulty_models(models: Iterable[tuple[Path, str]]) -> None:
    """Load each of these models, (folder, kind).

    Raises:
        DataError: a kind that nothing loads, a file that is cut off, or tensors that do not fit.
    """
    from lfr.mapping.saved_generators import load_generator
    from lfr.skills.saved_models import load_jacobian, load_prior, load_vae
    from lfr.transfer.model import load_policy

    loaders = {
        "skill_vae": load_vae,
        "skill_prior": load_prior,
        "hand_jacobian": load_jacobian,
        "generator": load_generator,
        "transferred_policy": load_policy,
    }
    for folder, kind in models:
        if kind not in loaders:
            raise DataError(
                "another kind of model",
                file=folder / "config.json",
                found=kind,
                expected=", ".join(loaders),
            )
        loaders[kind](folder)


def logs_of(dataset: Path, folder: Path) -> list[Path]:
    """The MCAP logs that a dataset was packed from, in the order of its episodes.

    Raises:
        DataError: the dataset does not name its logs, or one is not there or another than it was
            packed from.
    """
    with readable(dataset):
        contents = Contents.open(dataset)
        named = episode_logs(contents) if has_logs(contents) else []
    if not named:
        raise DataError("the dataset does not name its logs; publish it without them",
                        file=dataset / EPISODES, column="log_file")  # fmt: skip
    return [_log(folder, episode, *log) for episode, log in enumerate(named)]


def _log(folder: Path, episode: int, name: str | None, expected: str | None) -> Path:
    if name is None or expected is None:
        raise DataError("an episode that does not name its log; publish it without them",
                        file=folder, episode=episode, column="log_file")  # fmt: skip
    log = folder / Path(name).name
    found = file_hash(log)
    if found != expected:
        raise DataError(
            "another log than the episode was packed from",
            file=log,
            episode=episode,
            found=found[:12],
            expected=expected[:12],
        )
    return log
