"""The hook for pre-commit and the workflow of the documents call what there is."""

from __future__ import annotations

import argparse
import re
import shlex
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from lfr.curation.accepted import read_accepted
from lfr.curation.verify_command import add_arguments

ROOT = Path(__file__).parents[2]
BLOCKS = re.findall(r"^```yaml\n(.*?)^```", (ROOT / "docs/trust.md").read_text(), re.M | re.S)


def yaml(text: str) -> Any:
    return YAML(typ="safe").load(text)


def parsed(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return parser.parse_args(arguments)


def test_the_hook_runs_verify_with_the_arguments_of_the_document() -> None:
    (hook,) = yaml((ROOT / ".pre-commit-hooks.yaml").read_text())
    assert shlex.split(hook["entry"]) == ["lfr", "verify"]
    (config,) = (yaml(block) for block in BLOCKS if "repos:" in block)
    (used,) = config["repos"][0]["hooks"]
    assert used["id"] == hook["id"]
    assert parsed(used["args"]).path == Path("data/lerobot/NAME")


@pytest.mark.parametrize(
    ("file", "runs"),
    [
        ("data/lerobot/a/meta/info.json", True),
        ("meta/episodes/chunk-000/file-000.parquet", True),
        ("a/data/chunk-000/file-000.parquet", True),
        ("a/videos/observation.images.top/chunk-000/file-000.mp4", True),
        ("data/lerobot.dvc", True),
        ("dvc.lock", True),
        ("README.md", False),
        ("lfr/data/tables.py", False),
        ("results/metadata.json", False),
    ],
)
def test_the_hook_runs_where_a_dataset_changes(file: str, runs: bool) -> None:
    (hook,) = yaml((ROOT / ".pre-commit-hooks.yaml").read_text())
    assert bool(re.search(hook["files"], file)) == runs


def test_the_workflow_runs_verify() -> None:
    (workflow,) = (yaml(block) for block in BLOCKS if "runs-on:" in block)
    steps = workflow["jobs"]["verify"]["steps"]
    (command,) = (step["run"] for step in steps if "lfr verify" in step.get("run", ""))
    program, verify, *arguments = shlex.split(command)
    assert (program.rpartition("/")[2], verify) == ("lfr", "verify")
    options = parsed(arguments)
    written = {options.html.name, options.markdown.name}
    conditions = " ".join(step.get("if", "") for step in steps)
    assert written == set(re.findall(r"hashFiles\('(.+?)'\)", conditions))


def test_the_list_of_the_document_is_one(tmp_path: Path) -> None:
    (known,) = (block for block in BLOCKS if block.startswith("- {check"))
    (tmp_path / "known.yaml").write_text(known)
    assert len(read_accepted(tmp_path / "known.yaml")) == 3
