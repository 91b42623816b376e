"""A dataset on the Hugging Face Hub, whose files come when they are asked for.

Address, token and cache are huggingface_hub's: HF_ENDPOINT, HF_TOKEN or the stored login, HF_HOME;
with HF_HUB_OFFLINE=1 the cache alone is asked.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from lfr.data.source import VERSION
from lfr.errors import LfrError
from lfr.program import MACHINE

RELEASES = (VERSION, "v2.1", "v2.0")
"""Tags by which LeRobot marks a dataset's versions, in the order in which they are looked for."""

KIND = "dataset"
LOG_IN = "or log in with `hf auth login` or HF_TOKEN, if it is private"


def parse_name(text: str) -> tuple[str, str | None] | None:
    """Name and revision, if any, of `owner/name` or `owner/name@revision`; None of other texts."""
    found = re.fullmatch(r"([\w-][\w.-]*/[\w-][\w.-]*)(?:@(\S+))?", text, re.ASCII)
    return None if found is None else (found[1], found[2])


@dataclass(frozen=True)
class Repository:
    """One commit of a dataset on the Hub.

    Attributes:
        name: `owner/name`.
        folder: where in huggingface_hub's cache its files are, once they are there.
        files: all that it has, relative to the folder.
    """

    name: str
    folder: Path
    files: frozenset[str]

    @classmethod
    def find(cls, name: str, revision: str | None = None) -> Repository:
        """The dataset of this name, its metadata fetched.

        Args:
            revision: a branch, tag or commit; by default the newest of RELEASES that there is, or
                else the main branch.

        Raises:
            LfrError: there is none, or the Hub cannot be reached.
        """
        from huggingface_hub import HfApi, constants
        from huggingface_hub.errors import CachedRepoTreeNotFoundError, LocalEntryNotFoundError
        from huggingface_hub.utils import disable_progress_bars

        if not sys.stderr.isatty():
            disable_progress_bars()
        with _explained(name, revision):
            if constants.HF_HUB_OFFLINE:
                for one in (*RELEASES, "main") if revision is None else (revision,):
                    with suppress(LocalEntryNotFoundError, CachedRepoTreeNotFoundError):
                        return _metadata(name, one, offline=True)
                raise LfrError(f"no folder {name} here, nor is that dataset in the Hub's cache; "
                               "HF_HUB_OFFLINE is set, so the Hub is not asked")  # fmt: skip
            if revision is None:
                tags = {ref.name for ref in HfApi().list_repo_refs(name, repo_type=KIND).tags}
                revision = next((release for release in RELEASES if release in tags), "main")
            return _metadata(name, revision)

    def fetch(self, place: str) -> None:
        """Have a file, or all files of a folder, on the disk; nothing where there is none.

        Raises:
            LfrError: the Hub cannot be reached, or, offline, the cache has not all of them.
        """
        from huggingface_hub import constants, hf_hub_download, snapshot_download

        commit = self.folder.name
        lacking = [f for f in self.files if f == place or f.startswith(f"{place}/")
                   if not (self.folder / f).is_file()]  # fmt: skip
        if lacking and constants.HF_HUB_OFFLINE:
            raise LfrError(f"the Hub's cache lacks {len(lacking)} files of {self.name}, such as "
                           f"{min(lacking)}; HF_HUB_OFFLINE is set")  # fmt: skip
        with _explained(self.name, None):
            if place in lacking:
                hf_hub_download(self.name, place, repo_type=KIND, revision=commit)
            elif lacking:
                snapshot_download(self.name, repo_type=KIND, revision=commit,
                                  allow_patterns=f"{place}/*")  # fmt: skip


def _metadata(name: str, revision: str, *, offline: bool = False) -> Repository:
    from huggingface_hub import get_cached_repo_tree, snapshot_download

    folder = snapshot_download(name, repo_type=KIND, revision=revision, allow_patterns="meta/*",
                               local_files_only=offline)  # fmt: skip
    every = get_cached_repo_tree(name, repo_type=KIND, revision=Path(folder).name)
    return Repository(name, Path(folder), frozenset(file.path for file in every))


@contextmanager
def _explained(name: str, revision: str | None) -> Iterator[None]:
    """The library's errors as one line that says what to do, without the token."""
    import httpx
    from huggingface_hub.errors import (
        HFValidationError,
        RepositoryNotFoundError,
        RevisionNotFoundError,
    )

    nowhere = f"no folder {name} here, and"
    try:
        yield
    except RevisionNotFoundError:
        raise LfrError(f"{nowhere} the Hub's dataset has no revision {revision}") from None
    except (RepositoryNotFoundError, HFValidationError):
        raise LfrError(
            f"{nowhere} no such dataset on the Hub; correct the name, {LOG_IN}"
        ) from None
    except (httpx.HTTPError, OSError, ValueError, RuntimeError) as error:
        if getattr(error, "errno", None) in MACHINE:  # a full disk is not the Hub's fault
            raise
        raise LfrError(f"{nowhere} the Hub does not give the dataset: {plain(error)}") from None


def plain(error: BaseException) -> str:
    """An error's words on one line; the token, should a server repeat it, is blotted out."""
    from huggingface_hub import get_token

    text = re.sub(r"\s+", " ", str(error)).strip() or type(error).__name__
    token = get_token()
    text = text.replace(token, "***") if token else text
    return re.sub(r"\bhf_\w{8,}", "***", text)
