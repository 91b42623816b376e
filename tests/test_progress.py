"""Silent where there is no terminal, lines where they are asked for."""

import pytest

from lfr.progress import progress


def test_silent_without_a_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("LFR_PROGRESS", raising=False)
    assert list(progress([1, 2, 3])) == [1, 2, 3]
    assert capsys.readouterr().err == ""


def test_lines_with_count_rate_and_time(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("LFR_PROGRESS", "1")
    with progress(4, "record", "episode", initial=1) as bar:
        bar.update(3)
    first, *_, last = capsys.readouterr().err.splitlines()
    assert first.startswith("record:  25%")
    assert last.startswith("record: 100%")
    assert "4/4" in last
    assert "episode/s" in last
    assert "\r" not in last
