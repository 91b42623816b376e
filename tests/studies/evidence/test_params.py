"""What evidence.yaml asks for, and that what it misspells is named."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import pytest

from lfr.errors import LfrError, ParameterError, UnknownNameError
from studies.evidence.evidence_params import ASKED, Asked, Setting, merged, read_asked

ROOT = Path(__file__).parents[3]


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Asked:
    monkeypatch.chdir(ROOT)
    return read_asked()


def test_a_matrix_has_every_pair_once(asked: Asked) -> None:
    found = [transfer for _, transfer in asked.transfers(asked.settings["matrix"])]
    arms = [f"{arm}-joint_position" for arm in asked.matrix.arms]
    assert sorted((one.source, one.target) for one in found) == sorted(
        itertools.permutations(arms, 2)
    )
    assert {(one.task, one.common) for one in found} == {("stack", ("lift", "nut_assembly"))}


def test_options_differ_in_what_they_name_alone(asked: Asked) -> None:
    assert asked.mapping_params("ours") == asked.mapping
    paper = asked.mapping_params("paper")
    hand = replace(asked.mapping.hand, weight=0.0)
    assert paper == replace(asked.mapping, condition="none", hand=hand)


def test_methods_are_given_what_they_need(asked: Asked) -> None:
    assert asked.transfer_params("lfr", "sparse") == asked.transfer
    sac = asked.transfer_params("sac", "dense")
    assert (sac.batch, sac.reward, sac.steps) == (128, "dense", asked.transfer.steps)


def test_recordings_have_no_pictures_and_as_many_as_asked(asked: Asked) -> None:
    params = [asked.record_params(asked.settings[name]) for name in ("paper", "demonstrations")]
    assert [(one.cameras, one.episodes) for one in params] == [((), 50), ((), 200)]
    assert params[0].attempt == asked.record.attempt


def test_what_there_is_not_is_named(asked: Asked) -> None:
    with pytest.raises(UnknownNameError, match="transfer"):
        asked.transfers(Setting(("s9-nobody",), 1))
    with pytest.raises(ParameterError, match=r"options\.x: unknown parameter 'wight'"):
        merged(asked.mapping, {"wight": 1.0}, "options.x")
    with pytest.raises(ParameterError, match="wight"):
        merged(asked.mapping, {"hand": {"wight": 1.0}}, "options.x")


def test_a_misspelled_option_is_named_before_anything_runs(asked: Asked, tmp_path: Path) -> None:
    path = tmp_path / "asked.yaml"
    path.write_text(ASKED.read_text().replace("options: [paper, state", "options: [papr, state"))
    with pytest.raises(LfrError, match="papr"):
        read_asked(path)
