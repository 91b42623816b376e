"""Names of files by format strings that may be anybody's: as str.format has them, or refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lfr.data.templates import file_name, renamed

NEW = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
OLD = "videos/chunk-{episode_chunk:03d}/{video_key}/episode_{episode_index:06d}.mp4"
NAMES = {"episode_chunk": "chunk_index", "episode_index": "file_index", "video_key": "video_key"}


@given(chunk=st.integers(0, 10**9), file=st.integers(0, 10**9), key=st.text())
def test_lerobots_own_are_formatted_as_python_does(chunk: int, file: int, key: str) -> None:
    values = {"chunk_index": chunk, "file_index": file, "video_key": key}
    assert file_name(NEW, **values) == NEW.format(**values)
    old = OLD.format(episode_chunk=chunk, episode_index=file, video_key=key)
    assert file_name(renamed(OLD, NAMES), **values) == old


def test_braces_and_other_widths_stay() -> None:
    assert file_name("{{a}}-{n}-{n:d}-{n:4}-{n:04d}", n=7) == "{a}-7-7-   7-0007"
    assert renamed("{{a}}-{n:04d}-{n}", {"n": "m"}) == "{{a}}-{m:04d}-{m}"


@pytest.mark.parametrize(
    "template",
    ["{n:09999999999d}", "{n:0999d}", "{n:x}", "{n:{n}d}", "{n!r}", "{n.__class__}", "{n[0]}", "{}",
     "{0}", "{other}", "{n", "}", "{n:>9999999999}", "{key:03d}", None, 3, ["{n}"]],
)  # fmt: skip
def test_whatever_else_is_in_one_is_refused(template: object) -> None:
    with pytest.raises(ValueError, match=r"not one of|no format string|'[{}]'|code 'd'"):
        file_name(template, n=7, key="front")
