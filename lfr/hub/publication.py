"""What is published of a dataset or of models: every file under its name in the repository."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from lfr.data.tables import VERSION
from lfr.errors import DataError
from lfr.hub.checks import logs_of, refuse_faulty_dataset, refuse_faulty_models
from lfr.hub.dataset_facts import FOLDERS, dataset_files, read_facts, read_making
from lfr.hub.model_facts import CONFIG, TENSORS, read_models

CARD = "README.md"
INFO = "meta/info.json"
LOGS = "logs"


@dataclass(frozen=True)
class Publication:
    """One revision of a repository, whole.

    Attributes:
        kind: of the repository, as the Hub calls it.
        name: of what is published.
        files: by path in the repository, a file here or the content itself.
        tags: that name the revision when all of it is there.
        ours: pattern of the paths that belong to a publication of this kind. What an earlier
            revision had of them and this one has not is removed; other files stay.
    """

    kind: Literal["dataset", "model"]
    name: str
    files: Mapping[str, Path | bytes]
    tags: tuple[str, ...]
    ours: re.Pattern[str]

    @property
    def sizes(self) -> dict[str, int]:
        """Bytes of each file."""
        return {path: _size(content) for path, content in self.files.items()}

    @property
    def licensed(self) -> bool:
        """Whether the card's header names a licence."""
        text = self.files[CARD]
        header = text.partition(b"\n---")[0] if isinstance(text, bytes) else b""
        return b"\nlicense:" in header


def is_dataset(path: Path) -> bool:
    return (path / INFO).is_file()


def publication(
    path: Path,
    *,
    repo_id: str | None,
    results: Path,
    logs: Path | None = None,
    card: Path | None = None,
    license: str | None = None,
    tags: tuple[str, ...] = (),
) -> Publication:
    """What to publish of the dataset or the models at `path`, once it has been checked.

    Args:
        path: a dataset's folder, or a folder of models.
        repo_id: where it will be loaded from; None is a folder.
        results: what the stages noted; the cards quote it.
        logs: folder of the MCAP logs to publish beside a dataset.
        card: a card of one's own, instead of the generated one.
        license: for the generated card; None is that of this project for what its stages made, and
            none for a dataset by others.
        tags: further tags of the revision.

    Raises:
        DataError: what is there is faulty, or no dataset and no models.
    """
    if not path.is_dir():
        raise DataError("no such folder", file=path, expected="a dataset or a folder of models")
    of = _of_dataset if is_dataset(path) else _of_models
    return of(path, repo_id, results, logs, card, license, tags)


def dataset_card_files(
    path: Path, results: Path, *, repo_id: str | None = None, logs: bool = False,
    license: str | None = None,
) -> tuple[str, dict[str, bytes]]:  # fmt: skip
    """A dataset's card, and its picture by the name that the card calls it."""
    from lfr.hub.dataset_card import dataset_card
    from lfr.hub.picture import picture

    facts = read_facts(path)
    pictures = {f"{facts.name}.jpg": picture(path, c.key) for c in facts.cameras[:1]}
    shown = next(iter(pictures), None)
    making = read_making(facts, results)
    text = dataset_card(facts, making, repo_id=repo_id, picture=shown, logs=logs, license=license)
    return text, pictures


def model_card_text(
    path: Path, results: Path, *, repo_id: str | None = None, license: str | None = None
) -> tuple[str, str]:
    """A name for the models' card, and the card."""
    from lfr.hub.model_card import model_card

    facts = read_models(path, results)
    return facts.title, model_card(facts, repo_id=repo_id, license=license)


def _of_dataset(
    path: Path, repo_id: str | None, results: Path, logs: Path | None,
    card: Path | None, license: str | None, tags: tuple[str, ...],
) -> Publication:  # fmt: skip
    refuse_faulty_dataset(path)
    name = path.resolve().name
    files: dict[str, Path | bytes] = {
        file.relative_to(path).as_posix(): file for file in dataset_files(path)
    }
    if logs is not None:
        files |= {f"{LOGS}/{log.name}": log for log in logs_of(path, logs)}
    text, pictures = dataset_card_files(
        path, results, repo_id=repo_id, logs=logs is not None, license=license
    )
    files |= pictures
    files[CARD] = card.read_bytes() if card else text.encode()
    ours = re.compile(rf"({'|'.join((*FOLDERS, LOGS))})/.+")
    return Publication("dataset", name, files, (VERSION, *tags), ours)


def _of_models(
    path: Path, repo_id: str | None, results: Path, logs: Path | None,
    card: Path | None, license: str | None, tags: tuple[str, ...],
) -> Publication:  # fmt: skip
    if logs is not None:
        raise DataError("models have no MCAP logs; leave --with-logs out", file=path)
    facts = read_models(path, results)
    refuse_faulty_models((path / part.place, part.kind) for part in facts.parts)
    _, text = model_card_text(path, results, repo_id=repo_id, license=license)
    files: dict[str, Path | bytes] = {
        (path / part.place / name).relative_to(path).as_posix(): path / part.place / name
        for part in facts.parts
        for name in (CONFIG, TENSORS)
    }
    files[CARD] = card.read_bytes() if card else text.encode()
    ours = re.compile(rf"(.+/)?({re.escape(CONFIG)}|{re.escape(TENSORS)})")
    return Publication("model", facts.title, files, tags, ours)


def _size(content: Path | bytes) -> int:
    return len(content) if isinstance(content, bytes) else content.stat().st_size
