"""What can be wrong on a stage's command line or in params.yaml: one line, nothing written."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from typing import Any, get_type_hints

import pytest

from lfr.demos.recorder import RecordParams
from lfr.evaluation.protocol import EvaluateParams
from lfr.mapping.mapping_params import MappingParams
from lfr.params import read_section, read_yaml
from lfr.program import run_stage
from lfr.scenarios import transfers
from lfr.skills.skill_params import SkillsParams
from lfr.transfer.methods import METHODS
from lfr.transfer.transfer_params import TransferParams

from .tiny_project import ROOT

TINY = (ROOT / "tests" / "tiny_params.yaml").read_text()
SECTIONS: dict[str, type] = {
    "record": RecordParams,
    "skills": SkillsParams,
    "mapping": MappingParams,
    "transfer": TransferParams,
    "evaluate": EvaluateParams,
}
ROBOT, TASK = ["--robot", "panda"], ["--task", "lift"]
TRANSFER, METHOD = ["--transfer", "s1-panda-lift"], ["--method", "lfr"]
KEYS = {
    "record": [*ROBOT, *TASK],
    "pack": [*ROBOT, *TASK],
    "skills": ROBOT,
    "mapping": TRANSFER,
    "transfer": [*TRANSFER, *METHOD],
    "recordings": [*TRANSFER, *METHOD],
    "evaluate": [*TRANSFER, *METHOD],
    "report": [],
}


def main_of(stage: str) -> Callable[..., None]:
    return importlib.import_module(f"pipeline.{stage}").main


def refused(
    stage: str, arguments: list[str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> str:
    """The one line that the stage ends with; nothing but params.yaml is in the folder."""
    assert run_stage(main_of(stage), arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("lfr: error: ")
    assert printed.err.count("\n") == 1
    assert [path.name for path in folder.rglob("*") if path.is_file()] == ["params.yaml"]
    return printed.err


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "params.yaml").write_text(TINY)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("stage", ["record", "pack"])
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--robot", "pando", *TASK], "unknown robot 'pando'; valid: panda, sawyer"),
        ([*ROBOT, "--task", "lif"], "unknown task 'lif'; valid: lift, stack"),
    ],
)
def test_unknown_robot_or_task(
    stage: str, arguments: list[str], message: str, folder: Path, capsys: Any
) -> None:
    assert message in refused(stage, arguments, folder, capsys)


@pytest.mark.parametrize("stage", ["mapping", "transfer", "recordings", "evaluate"])
def test_unknown_transfer(stage: str, folder: Path, capsys: Any) -> None:
    arguments = ["--transfer", "s1-panda-fly", *KEYS[stage][2:]]
    expected = "unknown transfer 's1-panda-fly'; valid: s1-panda-lift, s1-sawyer-stack"
    assert expected in refused(stage, arguments, folder, capsys)


@pytest.mark.parametrize("stage", ["transfer", "recordings", "evaluate"])
def test_unknown_method(stage: str, folder: Path, capsys: Any) -> None:
    arguments = [*TRANSFER, "--method", "ppo"]
    assert "unknown method 'ppo'; valid: lfr" in refused(stage, arguments, folder, capsys)


@pytest.mark.parametrize("stage", ["record", "skills", "mapping", "transfer", "evaluate", "pack"])
def test_unknown_parameter(stage: str, folder: Path, capsys: Any) -> None:
    section = f"\n{stage}: {{speed: 3}}\n"
    lines = [line for line in TINY.splitlines() if not line.startswith(f"{stage}:")]
    if stage in ("record", "skills", "transfer"):  # written over several lines
        start = TINY.splitlines().index(f"{stage}:")
        after = TINY.splitlines()[start + 1 :]
        count = next(i for i, line in enumerate(after) if not line.startswith(" "))
        lines = TINY.splitlines()[:start] + after[count:]
    (folder / "params.yaml").write_text("\n".join(lines) + section)
    printed = refused(stage, KEYS[stage], folder, capsys)
    assert f"params.yaml: {stage}: unknown parameter 'speed'; valid: " in printed


@pytest.mark.parametrize(
    ("stage", "message"),
    [
        ("pack", "no logs; record episodes first: data/logs/panda-lift"),
        ("skills", "missing: data/lerobot/panda-"),
        ("mapping", "missing: models/skills/sawyer/lift+nut_assembly+pick_place/vae"),
        ("transfer", "missing: models/skills/sawyer/lift+nut_assembly+pick_place/vae"),
        ("recordings", "missing: models/learning/s1-panda-lift-lfr/seed-0/curve.csv"),
        ("evaluate", "missing: models/transfer/s1-panda-lift-lfr/seed-0"),
        ("report", "missing: results/transfer/s1-panda-lift-lfr.json"),
    ],
)
def test_what_an_earlier_stage_should_have_left_is_named(
    stage: str, message: str, folder: Path, capsys: Any
) -> None:
    assert message in refused(stage, KEYS[stage], folder, capsys)


def test_a_scenario_that_does_not_fit_is_named(folder: Path, capsys: Any) -> None:
    text = TINY.replace("new: {panda: lift, sawyer: stack}", "new: {panda: lift, sawyer: lft}")
    (folder / "params.yaml").write_text(text)
    assert "unknown task 'lft'" in refused("skills", ROBOT, folder, capsys)


def test_unknown_robot_or_transfer_of_the_skills(folder: Path, capsys: Any) -> None:
    expected = "unknown robot 'pando'; valid: panda, sawyer"
    assert expected in refused("skills", ["--robot", "pando"], folder, capsys)
    text = TINY.replace("transfers: [s1-panda-lift]", "transfers: [s1-panda-fly]")
    (folder / "params.yaml").write_text(text)
    assert "unknown transfer 's1-panda-fly'; valid: " in refused("skills", ROBOT, folder, capsys)


@pytest.mark.parametrize("path", [ROOT / "params.yaml", ROOT / "tests" / "tiny_params.yaml"])
def test_the_parameter_files_fit_the_code(path: Path) -> None:
    for section, cls in SECTIONS.items():
        read_section(cls, section, path)
    content, known = read_yaml(path), transfers(path)
    assert set(content["transfers"]) <= set(known)
    assert set(content["methods"]) <= set(METHODS)


def test_params_yaml_states_every_parameter() -> None:
    """No value of the main job is hidden in a default."""
    content = read_yaml(ROOT / "params.yaml")
    missing = [
        name
        for section, cls in SECTIONS.items()
        for name in unstated(cls, content[section], section)
    ]
    assert not missing


def test_the_defaults_are_those_of_the_main_job() -> None:
    """Whoever calls the library gets what was measured."""
    for section, cls in SECTIONS.items():
        assert read_section(cls, section, ROOT / "params.yaml") == cls()


def unstated(cls: Any, stated: dict[str, Any], where: str) -> list[str]:
    hints = get_type_hints(cls)
    found = []
    for field in fields(cls):
        place = f"{where}.{field.name}"
        if field.name not in stated:
            found.append(place)
            continue
        made = field.default_factory() if field.default_factory is not MISSING else None
        kind = type(made) if is_dataclass(made) else hints[field.name]
        if isinstance(kind, type) and is_dataclass(kind):
            found += unstated(kind, stated[field.name], place)
    return found
