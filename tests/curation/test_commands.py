"""The commands as docs/trust.md writes them."""

import shlex
from importlib import import_module
from pathlib import Path

import pytest

from lfr import cli
from lfr.curation.verify import CHECKS
from tests.test_docs import lines_to_run

from .broken import BROKEN

PAGE = (Path(__file__).parents[2] / "docs/trust.md").read_text()
COMMANDS = ("verify", "replay", "recover", "edit")


def test_documented_commands_parse(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []
    for name in COMMANDS:
        monkeypatch.setattr(import_module(cli.COMMANDS[name][1]), "run", seen.append)
    lines = [line for line in lines_to_run(PAGE) if line.startswith("lfr ")]
    assert {line.split()[1] for line in lines} == set(COMMANDS)
    for line in lines:
        assert cli.main(shlex.split(line)[1:]) == 0
    assert len(seen) == len(lines)


def test_every_kind_of_finding_is_documented() -> None:
    kinds = {check for _, check, _, _ in BROKEN.values()} | {"averaged-quantiles"}
    assert len(CHECKS) <= len(kinds)
    assert [kind for kind in sorted(kinds) if f"`{kind}`" not in PAGE] == []
