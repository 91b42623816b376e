"""What must hold before anything is published: the one place that says what is refused."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pyarrow as pa

from lfr.artifacts import file_hash
from lfr.curation.verify import verify_dataset
from lfr.data.tables import DatasetFiles
from lfr.errors import DataError


def refuse_faulty_dataset(path: Path) -> None:
    """Hold a dataset to what `lfr verify` asks of it; warnings do not count.

    Raises:
        DataError: the first thing that is wrong, with its place.
    """
    report = verify_dataset(path)
    if report.errors:
        first = report.errors[0]
        raise DataError(
            f"{first.check}: {first.message} ({len(report.errors)} errors; `lfr verify` lists all)",
            file=path / first.file,
            episode=first.episode,
            column=first.column,
            found=first.found,
            expected=first.expected,
        )


def refuse_faulty_models(models: Iterable[tuple[Path, str]]) -> None:
    """Load each of these models, (folder, kind).

    Raises:
        DataError: a kind that nothing loads, a file that is cut off, or tensors that do not fit.
    """
    from lfr.mapping.artifacts import load_generator
    from lfr.skills.artifacts import load_prior, load_vae
    from lfr.transfer.model import load_policy

    loaders = {
        "skill_vae": load_vae,
        "skill_prior": load_prior,
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
    episodes = DatasetFiles.open(dataset).episodes
    return [_log(folder, i, *named) for i, named in enumerate(_named(episodes, dataset))]


def _named(episodes: pa.Table, dataset: Path) -> list[tuple[str, str]]:
    columns = ("log_file", "log_sha256")
    for column in columns:
        if column not in episodes.column_names:
            raise DataError(
                "the dataset does not name its logs; publish it without them",
                file=dataset / "meta" / "episodes",
                column=column,
            )
    files, hashes = (episodes[column].to_pylist() for column in columns)
    return list(zip(files, hashes, strict=True))


def _log(folder: Path, episode: int, name: str, expected: str) -> Path:
    log = folder / name
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
