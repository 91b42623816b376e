"""The example of arms and simulators that nobody here wrote, small: it runs from end to end."""

from __future__ import annotations

import csv
import importlib
from pathlib import Path
from typing import Any

import pytest
import yaml

pytest.importorskip("metaworld", reason="extra `examples` is not installed")
pytest.importorskip("gymnasium_robotics", reason="extra `examples` is not installed")
SMALL: dict[str, Any] = {
    "skills": {"vae": {"steps": 100, "hidden": 32}, "prior": {"steps": 100, "hidden": 32}},
    "mapping": {"steps": 100, "hidden": 32},
    "transfer": {"steps": 600, "warm_up": 200, "evaluate_every": 600, "evaluation_episodes": 2},
    "evaluate": {"episodes": 4},
}


@pytest.mark.slow
def test_it_runs_and_leaves_a_row_for_every_policy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    example = importlib.import_module("examples.metaworld_fetch.__main__")
    params = yaml.safe_load(example.PARAMS.read_text())
    for section, changes in SMALL.items():
        for name, value in changes.items():
            whole = params[section]
            whole[name] = {**whole[name], **value} if isinstance(value, dict) else value
    (tmp_path / "small.yaml").write_text(yaml.safe_dump(params, sort_keys=False))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(example, "PARAMS", tmp_path / "small.yaml")
    monkeypatch.setattr(example, "EPISODES", 4)
    monkeypatch.setattr("sys.argv", ["metaworld_fetch", "--seeds", "1"])
    example.main()
    rows = list(csv.DictReader(example.TABLE.open()))
    methods = {"identity", "no_generator", "recoded", "linear", "mapped", "oracle",
               "identity, converted", "lfr", "sac"}  # fmt: skip
    assert {row["method"] for row in rows} == methods
    assert all(row["starts"] == str(len(row["outcomes"])) == "4" for row in rows)
