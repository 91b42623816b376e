"""Publishing to the Hub: large files first, one commit, the tags last.

What loads is a commit or a tag. Large files go to storage that no revision shows until the commit
names them, and the Hub makes a commit whole or not at all; LeRobot loads a dataset by the tag
`v3.0` (lerobot issue 2684), which is set on that very commit. So a connection cut anywhere leaves
what was there before, or nothing that loads, and the next attempt finds the large files sent.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from lfr.data.repository import plain
from lfr.data.tables import VERSION
from lfr.errors import LfrError
from lfr.hub.publication import CARD, Publication

if TYPE_CHECKING:
    from huggingface_hub import HfApi

AGAIN = "run the same command again; what the Hub has already is not sent twice"
BROKEN = (ConnectionError, TimeoutError)  # what hf_xet raises
LOG_IN = "log in with `hf auth login` or set HF_TOKEN, with the right to write there"


class PublishError(LfrError):
    """The Hub refused, or could not be reached."""


def publish_to_hub(
    publication: Publication,
    repo_id: str,
    *,
    private: bool | None = None,
    move_tags: bool = False,
) -> tuple[str, str]:
    """Publish to a repository on the Hub, made if missing.

    The token and the Hub's address are huggingface_hub's: HF_TOKEN or the stored login, and
    HF_ENDPOINT.

    Args:
        repo_id: "owner/name".
        private: of a new repository; None takes the owner's default.
        move_tags: let a tag that names another revision name this one. LeRobot's own, the format's
            version, always does.

    Returns:
        The repository's address and the commit.

    Raises:
        PublishError: no such owner or no right to write, a card that the Hub does not accept, a
            connection cut for longer than huggingface_hub tries again, a commit by someone
            else meanwhile, or a tag that names another revision.
    """
    from huggingface_hub import CommitOperationAdd, CommitOperationDelete, HfApi
    from huggingface_hub.utils import disable_progress_bars

    if not sys.stderr.isatty():
        disable_progress_bars()
    api, kind = HfApi(), publication.kind
    with _explained(repo_id):
        url = api.create_repo(repo_id, repo_type=kind, private=private, exist_ok=True)
        head = api.repo_info(repo_id, repo_type=kind)
        if private and not head.private:
            raise PublishError(f"{repo_id} is there and public; make it private on the Hub first")
        named = _tags(api, repo_id, kind)
        kept = () if move_tags else tuple(tag for tag in publication.tags if tag != VERSION)
        for tag in kept:
            if named.get(tag, head.sha) != head.sha:
                raise PublishError(f"{repo_id}: nothing published: {_taken(tag, named[tag])}")
        there = api.list_repo_files(repo_id, repo_type=kind, revision=head.sha)
        stale = [path for path in there if _is_stale(path, publication)]
        commit = api.create_commit(
            repo_id,
            [
                *(CommitOperationDelete(path) for path in stale),
                *(CommitOperationAdd(path, file) for path, file in publication.files.items()),
            ],
            commit_message=f"Publish {publication.name}",
            repo_type=kind,
            parent_commit=head.sha,
        )
        left = [tag for tag in kept if named.get(tag, commit.oid) != commit.oid]
        for tag in publication.tags:
            if tag not in left:
                _set_tag(api, repo_id, kind, tag, commit.oid)
        for tag in left:
            raise PublishError(
                f"{repo_id}: published as {commit.oid}, but {_taken(tag, named[tag])}"
            )
    return str(url), commit.oid


def _is_stale(path: str, publication: Publication) -> bool:
    """Whether an earlier publication put this file there and this one has it no more."""
    if path in publication.files or path == CARD:
        return False
    return publication.ours.fullmatch(path) is not None


def _set_tag(api: HfApi, repo_id: str, kind: str, tag: str, commit: str) -> None:
    """Let a tag name the commit. A tag cannot be moved: between the two calls it names nothing."""
    tags = _tags(api, repo_id, kind)
    if tags.get(tag) == commit:
        return
    if tag in tags:
        api.delete_tag(repo_id, tag=tag, repo_type=kind)
    api.create_tag(repo_id, tag=tag, revision=commit, repo_type=kind)


def _tags(api: HfApi, repo_id: str, kind: str) -> dict[str, str]:
    """Tag -> the commit that it names."""
    refs = api.list_repo_refs(repo_id, repo_type=kind)
    return {ref.name: ref.target_commit for ref in refs.tags}


def _taken(tag: str, commit: str) -> str:
    return f"the tag {tag} names {commit[:12]}; choose another, or --move-tags"


@contextmanager
def _explained(repo_id: str) -> Iterator[None]:
    """The library's errors as one line that says what to do, without the token."""
    import httpx
    from huggingface_hub.errors import HFValidationError, LocalTokenNotFoundError

    try:
        yield
    except LocalTokenNotFoundError:
        raise PublishError(f"cannot publish to {repo_id}: found no token; {LOG_IN}") from None
    except HFValidationError as error:
        raise PublishError(f"{repo_id!r} is no repository: {plain(error)}") from None
    except (httpx.HTTPError, *BROKEN, RuntimeError, ValueError) as error:  # RuntimeError: uploads
        raise PublishError(f"cannot publish to {repo_id}: {_reason(error)}") from None


def _reason(error: BaseException) -> str:
    import httpx

    causes = [error]  # the library wraps what broke an upload
    while (cause := causes[-1].__cause__) is not None:
        causes.append(cause)
    response = next((r for c in causes if (r := getattr(c, "response", None)) is not None), None)
    status = getattr(response, "status_code", None)
    if status in (401, 403):
        return f"the Hub says {status}; {LOG_IN}"
    if status == 412:
        return f"someone else has committed there meanwhile; {AGAIN}"
    if status is not None and status >= 500:
        return f"the Hub says {status}; {AGAIN}"
    lost = (httpx.TransportError, *BROKEN)
    if (broken := next((each for each in causes if isinstance(each, lost)), None)) is not None:
        return f"the connection broke ({plain(broken)}); {AGAIN}"
    return plain(error)
