"""Plain parameters: what is merged, what is refused, and that all of docs/method.md is set back."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from typing import Any

import pytest

from lfr.demos.recorder import RecordParams
from lfr.errors import ParameterError
from lfr.mapping.training import MappingParams
from lfr.params import read_section
from lfr.skills.params import SkillsParams
from pipeline.paper._plain import merged, plain_section
from pipeline.paper._stage import PARAMS

from ..tiny_project import ROOT

SECTIONS: dict[Any, Any] = {
    "record": RecordParams, "skills": SkillsParams, "mapping": MappingParams
}  # fmt: skip
MAIN = """
record: {episodes: 7, camera: {name: agentview}, attempt: {expert: {gain: 5.0, noise: 0.3}}}
skills: {held_out: 0.2, vae: {latent_dim: 16, hidden: 32}}
mapping: {steps: 9}
"""
PLAIN = """
plain:
  record: {attempt: {expert: {noise: 0.0}, drift: {steps: 0}}, camera: null}
  skills: {vae: {latent_dim: 10}}
"""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "params.yaml").write_text(MAIN)
    (tmp_path / "paper").mkdir()
    (tmp_path / PARAMS).write_text(PLAIN)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("main", "changes", "both"),
    [
        ({}, {}, {}),
        ({"a": 1}, {}, {"a": 1}),
        ({"a": {"b": 1, "c": 2}, "d": 3}, {"a": {"c": 4}}, {"a": {"b": 1, "c": 4}, "d": 3}),
        ({"a": {"b": {"c": 1}}}, {"a": {"b": {"e": 2}}}, {"a": {"b": {"c": 1, "e": 2}}}),
        ({"a": {"b": 1}}, {"a": None}, {"a": None}),
        ({"a": None}, {"a": {"b": 1}}, {"a": {"b": 1}}),
        ({"a": [1, 2, 3]}, {"a": [4]}, {"a": [4]}),
        ({"a": 1}, {"b": {"c": 2}}, {"a": 1, "b": {"c": 2}}),
    ],
)
def test_changes_go_over_what_is_there_key_by_key(main: dict, changes: dict, both: dict) -> None:
    before = repr((main, changes))
    assert merged(main, changes) == both
    assert repr((main, changes)) == before


def test_the_main_jobs_sections_hold_where_plain_says_nothing(project: Path) -> None:
    record = plain_section(RecordParams, "record")
    assert (record.episodes, record.camera) == (7, None)
    assert (record.attempt.expert.gain, record.attempt.expert.noise) == (5.0, 0.0)
    assert record.attempt.expert.perturbation == RecordParams().attempt.expert.perturbation
    assert record.attempt.drift.steps == 0
    skills = plain_section(SkillsParams, "skills")
    assert (skills.held_out, skills.vae.latent_dim, skills.vae.hidden) == (0.2, 10, 32)
    assert plain_section(MappingParams, "mapping") == MappingParams(steps=9)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("latent_dim", "latent_dims", r"plain.skills.vae: unknown parameter 'latent_dims'; valid"),
        ("{noise: 0.0}", "{noise: none}", r"plain.record.attempt.expert.noise: found 'none'"),
        ("  skills", "  skill", r"paper/params.yaml: plain: unknown parameter 'skill'; valid"),
        ("skills: {vae: {latent_dim: 10}}", "skills: 10", r"plain.skills: found 10, expected dict"),
        ("plain:", "plane:", r"no section 'plain'; found: plane"),
    ],
)
def test_what_does_not_fit_is_named(project: Path, old: str, new: str, message: str) -> None:
    assert old in PLAIN
    (project / PARAMS).write_text(PLAIN.replace(old, new))
    with pytest.raises(ParameterError, match=message):
        _all_sections()


def _all_sections() -> dict[str, Any]:
    return {section: plain_section(cls, section) for section, cls in SECTIONS.items()}


def test_every_choice_beyond_the_paper_is_set_back(monkeypatch: pytest.MonkeyPatch) -> None:
    """The last column of docs/method.md's table; what stays, paper/params.yaml names."""
    monkeypatch.chdir(ROOT)
    page = Path("docs/method.md").read_text().split("## What goes beyond the paper")[1]
    table = page.split("\n## ")[0]
    choices = re.findall(r"`((?:record|skills|mapping)(?:\.\w+)+)` ([\d.]+)", table)
    assert len(choices) > 8
    found = _all_sections()
    kept = []
    for name, value in choices:
        section, *path = name.split(".")
        setting: Any = found[section]
        for part in path:
            setting = getattr(setting, part)
        if setting != float(value):
            kept.append(name)
    assert kept == ["record.attempt.linger", "skills.vae.learning_rate"]
    assert found["mapping"].symmetry.copies == 0


def test_nothing_else_is_changed(monkeypatch: pytest.MonkeyPatch) -> None:
    """As long a training of as large networks on as many episodes."""
    monkeypatch.chdir(ROOT)
    changed = {
        name
        for section, cls in SECTIONS.items()
        for name in _differing(read_section(cls, section), plain_section(cls, section), section)
    }
    assert changed == {
        "record.attempt.expert.noise", "record.attempt.expert.perturbation",
        "record.attempt.expert.slip",
        "record.attempt.drift.steps", "record.camera",
        "skills.vae.execute", "skills.vae.latent_dim", "skills.vae.augment",
        "skills.prior.input_noise", "skills.prior.symmetry.copies",
        "mapping.symmetry.copies", "mapping.state_noise", "mapping.posterior_share",
    }  # fmt: skip


def _differing(one: Any, other: Any, name: str) -> set[str]:
    """The names of the parameters in which two sections differ."""
    if type(one) is not type(other) or not dataclasses.is_dataclass(one):
        return set() if one == other else {name}
    parts = [field.name for field in dataclasses.fields(one)]
    return set().union(
        *(_differing(getattr(one, p), getattr(other, p), f"{name}.{p}") for p in parts)
    )
