"""Episodes against the MCAP logs they were packed from, by their hashes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from lfr.artifacts import file_hash
from lfr.curation.contents import EPISODES, Contents
from lfr.curation.finding import Finding

COLUMNS = ("log_file", "log_sha256")


def has_logs(contents: Contents) -> bool:
    """Whether the dataset says which logs it was packed from."""
    return set(COLUMNS) <= set(contents.episodes.column_names)


def default_folder(path: Path) -> Path | None:
    """`data/logs/<dataset>` of a dataset `data/lerobot/<dataset>`; None where there is none."""
    folder = path.resolve()
    place = folder.parent.parent / "logs" / folder.name
    return place if place.is_dir() else None


def episode_logs(contents: Contents) -> list[tuple[str | None, str | None]]:
    """File name and sha256 of each episode's log."""
    files, hashes = (contents.episodes[column].to_pylist() for column in COLUMNS)
    return list(zip(files, hashes, strict=True))


def check_logs(contents: Contents, folder: Path | None) -> Iterator[Finding]:
    """No log was packed twice; each that is in `folder` is the one that was packed."""
    if not has_logs(contents):
        return
    logs = episode_logs(contents)
    seen: dict[str, int] = {}
    for episode, (_, sha256) in enumerate(logs):
        if sha256 is not None and seen.setdefault(sha256, episode) != episode:
            yield Finding("log", "the same log as another episode's", file=EPISODES,
                          episode=episode, column="log_sha256", found=sha256,
                          expected=f"another than episode {seen[sha256]}'s")  # fmt: skip
    if folder is None:
        return
    for episode, (name, sha256) in enumerate(logs):
        if name is None:
            continue
        log = folder / Path(name).name
        if not log.is_file():
            yield Finding("log", "the log is not there", "warning", EPISODES, episode, "log_file",
                          found=name)  # fmt: skip
        elif (found := file_hash(log)) != sha256:
            yield Finding("log", "another log than the episode was packed from", file=str(log),
                          episode=episode, column="log_sha256", found=found,
                          expected=sha256)  # fmt: skip
