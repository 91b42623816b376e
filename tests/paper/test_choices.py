"""Choices between the main job's and the paper's reading."""

from __future__ import annotations

import pytest

from lfr.errors import ParameterError
from lfr.mapping.training import MappingParams
from lfr.params import from_mapping, read_section
from lfr.skills.demonstrations import DATASETS
from lfr.skills.params import SkillsParams
from pipeline.paper import _plain
from pipeline.paper._choices import PARTS, Choices, choices
from pipeline.paper._plain import plain_section
from pipeline.paper.plain_parts import PartsParams, parts_of

from ..tiny_project import ROOT


@pytest.fixture(autouse=True)
def in_the_project(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


def test_nothing_set_back_is_the_main_job_and_everything_is_plain() -> None:
    ours, plain = choices(()), choices(PARTS)
    assert ours.datasets == DATASETS
    assert ours.skills == read_section(SkillsParams, "skills")
    assert ours.mapping == read_section(MappingParams, "mapping")
    assert plain.datasets == _plain.DATASETS
    assert plain.skills == plain_section(SkillsParams, "skills")
    assert plain.mapping == plain_section(MappingParams, "mapping")


@pytest.mark.parametrize("part", PARTS)
def test_a_part_alone_changes_nothing_else(part: str) -> None:
    ours, plain, found = choices(()), choices(PARTS), choices([part])

    def parts(of: Choices) -> dict[str, object]:
        return {
            "demonstrations": of.datasets, "vae": of.skills.vae, "prior": of.skills.prior,
            "mapping": of.mapping,
        }  # fmt: skip

    assert parts(found) == parts(ours) | {part: parts(plain)[part]}
    assert parts(ours)[part] != parts(plain)[part]


def test_what_a_name_sets_back() -> None:
    assert parts_of("vae") == {"vae"}
    assert parts_of("all_but_vae") == {"demonstrations", "prior", "mapping"}


@pytest.mark.parametrize("name", ["vaes", "all_but_", "all_but", ""])
def test_a_name_of_no_part_is_refused(name: str) -> None:
    section = {"transfers": ["s1-panda-lift"], "plain": ["vae", name]}
    with pytest.raises(ParameterError, match=r"plain must be of demonstrations, vae, prior, mapp"):
        from_mapping(PartsParams, section, "plain_parts")
