"""Choices between the main job's and the paper's reading."""

from __future__ import annotations

from pathlib import Path

import pytest

from lfr.errors import ParameterError
from lfr.mapping.training import MappingParams
from lfr.params import from_mapping, read_section
from lfr.skills.demonstrations import DATASETS
from lfr.skills.params import SkillsParams
from pipeline.paper import _plain
from pipeline.paper._choices import PARTS, Choices, choices
from pipeline.paper._plain import plain_section
from pipeline.paper._stage import PARAMS
from pipeline.paper.plain_parts import PartsParams, parts_of

from ..tiny_project import ROOT


@pytest.fixture
def in_the_project(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


@pytest.mark.usefixtures("in_the_project")
def test_nothing_set_back_is_the_main_job_and_everything_is_plain() -> None:
    ours, plain = choices(()), choices(PARTS)
    assert ours.datasets == DATASETS
    assert ours.skills == read_section(SkillsParams, "skills")
    assert ours.mapping == read_section(MappingParams, "mapping")
    assert plain.datasets == _plain.DATASETS
    assert plain.skills == plain_section(SkillsParams, "skills")
    assert plain.mapping == plain_section(MappingParams, "mapping")


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.usefixtures("in_the_project")
def test_a_part_alone_changes_nothing_else(part: str) -> None:
    ours, plain, found = choices(()), choices(PARTS), choices([part])
    assert _parts(found) == _parts(ours) | {part: _parts(plain)[part]}
    assert _parts(ours)[part] != _parts(plain)[part]


def _parts(of: Choices) -> dict[str, object]:
    vae = vars(of.skills.vae)
    return {
        "demonstrations": of.datasets,
        "execute": vae["execute"],
        "vae": {name: value for name, value in vae.items() if name != "execute"},
        "prior": of.skills.prior,
        "mapping": of.mapping,
    }


def test_what_is_in_no_part_may_not_be_plain(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("paper").mkdir()
    Path("params.yaml").write_text("skills: {held_out: 0.1}\nmapping: {}\n")
    PARAMS.write_text("plain: {skills: {held_out: 0.2}}\n")
    with pytest.raises(ParameterError, match=r"plain.skills: only vae and prior may differ"):
        choices(PARTS)


def test_what_a_name_sets_back() -> None:
    assert parts_of("vae") == ["vae"]
    assert parts_of("all_but_vae") == ["demonstrations", "execute", "prior", "mapping"]


@pytest.mark.parametrize("name", ["vaes", "all_but_", "all_but", ""])
def test_a_name_of_no_part_is_refused(name: str) -> None:
    section = {"transfers": ["s1-panda-lift"], "set_back": ["vae", name]}
    with pytest.raises(ParameterError, match=r"set_back must be of demonstrations, execute, vae,"):
        from_mapping(PartsParams, section, "plain_parts")


@pytest.mark.parametrize("twice", ["transfers", "set_back"])
def test_one_of_them_twice_is_refused(twice: str) -> None:
    section = {"transfers": ["s1-panda-lift"], "set_back": ["vae"]}
    section[twice] *= 2
    with pytest.raises(ParameterError, match=f"{twice} must name each once"):
        from_mapping(PartsParams, section, "plain_parts")
