"""Who learns from which seeds and rewards, with which parameters; and paper/params.yaml itself."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import pytest

from lfr.errors import ParameterError, UnknownNameError
from lfr.imitation.params import ImitationParams
from lfr.params import read_section, read_yaml
from lfr.robots import ACTION_NAMES
from lfr.scenarios import transfer as transfer_named
from lfr.transfer.methods import METHODS
from lfr.transfer.params import TransferParams
from pipeline.paper._plan import Learning, learning
from pipeline.paper._stage import PARAMS, PaperSeeds, judging, paper_seeds

from ..tiny_project import ROOT

MAIN = "transfer: {steps: 700, batch: 8, policy_lr: 1.0e-3}\n"
LEARN = """
learn:
  methods: {tables: [lfr, sac], ablations: [only_lift], questions: [spirl]}
  rewards: {tables: [sparse, dense], ablations: [dense], questions: [sparse]}
  transfer: {batch: 16, tau: 0.1}
  of: {lfr: {}, sac: {batch: 32, dense_scale: 1.0}}
"""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "params.yaml").write_text(MAIN)
    (tmp_path / "paper").mkdir()
    (tmp_path / PARAMS).write_text(LEARN)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def shipped(monkeypatch: pytest.MonkeyPatch) -> Learning:
    """The plan of paper/params.yaml itself."""
    monkeypatch.chdir(ROOT)
    return learning()


def test_a_method_has_the_main_jobs_parameters_with_its_own_on_top(project: Path) -> None:
    plan = learning()
    main = TransferParams(steps=700, batch=8, policy_lr=1e-3)
    every = dataclasses.replace(main, batch=16, tau=0.1)
    assert plan.params_of("lfr", "sparse") == every
    own = dataclasses.replace(every, batch=32, dense_scale=1.0, reward="dense")
    assert plan.params_of("sac", "dense") == own
    assert plan.params_of("spirl", "sparse") == every  # it has no entry under `of`


def test_rewards_and_seeds_go_by_group(project: Path) -> None:
    plan, seeds = learning(), PaperSeeds(tables=(4, 5, 6), questions=(4, 6))
    assert [plan.group(method) for method in ("sac", "only_lift", "spirl")] == [
        "tables", "ablations", "questions",
    ]  # fmt: skip
    assert plan.rewards_of("sac") == ("sparse", "dense")
    assert plan.rewards_of("only_lift") == ("dense",)
    assert plan.rewards_of("spirl") == ("sparse",)
    assert plan.seeds_of("sac", seeds) == (4, 5, 6)
    assert plan.seeds_of("only_lift", seeds) == plan.seeds_of("spirl", seeds) == (4, 6)


def test_an_unknown_method_is_named(project: Path) -> None:
    with pytest.raises(UnknownNameError, match="'sca'; valid: lfr, sac, only_lift, spirl"):
        learning().rewards_of("sca")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("tau: 0.1", "tua: 0.1", r"learn.of.sac: unknown parameter 'tua'; valid: steps"),
        ("{batch: 32,", "{bacth: 32,", r"learn.of.sac: unknown parameter 'bacth'; valid: steps"),
        ("{batch: 32,", "{batch: many,", r"learn.of.sac.batch: found 'many', expected int"),
        ("  of:", "  off:", r"paper/params.yaml: learn: unknown parameter 'off'; valid: methods"),
        (", questions: [spirl]", "", r"learn.methods: parameter 'questions' is missing"),
        ("[sparse, dense]", "[sparse, dens]", r"reward: found 'dens'; valid: sparse, dense"),
    ],
)
def test_what_does_not_fit_is_named(project: Path, old: str, new: str, message: str) -> None:
    assert old in LEARN
    (project / PARAMS).write_text(LEARN.replace(old, new))
    with pytest.raises(ParameterError, match=message):
        _all_of("sac")


def _all_of(method: str) -> list[TransferParams]:
    return [learning().params_of(method, reward) for reward in learning().rewards_of(method)]


def test_every_method_that_learns_is_there_and_says_what_it_needs(shipped: Learning) -> None:
    groups = vars(shipped.methods)
    methods = [method for group in groups.values() for method in group]
    assert len(set(methods)) == len(methods) == sum(map(len, groups.values())) > 0
    assert set(methods) == set(shipped.of)
    assert set(methods) <= set(METHODS)
    for method in methods:
        for reward in shipped.rewards_of(method):
            assert shipped.params_of(method, reward).reward == reward


def test_methods_differ_from_the_main_job_only_in_what_they_name(shipped: Learning) -> None:
    """As many environment steps, as large networks, as many critics for everybody."""
    main = read_section(TransferParams, "transfer")
    for method, own in shipped.of.items():
        named = {"reward", *shipped.transfer, *own}
        assert not named & {"steps", "critics", "critic_hidden", "evaluation_episodes"}
        found = vars(shipped.params_of(method, "dense"))
        assert {key for key, value in vars(main).items() if found[key] != value} <= named


def test_table_iii_has_its_transfers_and_their_common_tasks(shipped: Learning) -> None:
    common = {f"only_{task}" for name in shipped.ablated for task in transfer_named(name).common}
    assert len(shipped.ablated) > 1
    only = [method for method in shipped.methods.ablations if method.startswith("only_")]
    for name in shipped.ablated:
        assert name in read_yaml(Path("params.yaml"))["transfers"]
        assert {f"only_{task}" for task in transfer_named(name).common} == set(only)
    assert common == set(only)


def test_sacs_entropy_is_the_usual_one(shipped: Learning) -> None:
    """-A nats: so far from the uniform distribution over [-1, 1]^A, which has A log 2."""
    actions = len(ACTION_NAMES)
    assert actions == 7
    found = shipped.params_of("sac", "dense").target_divergence
    assert found == pytest.approx(actions * (1 + math.log(2)), abs=0.005)


def test_the_other_sections_read(shipped: Learning) -> None:
    seeds, judges = paper_seeds(), judging()
    assert len(seeds.tables) >= 5  # the protocol: 5 seeds for Tables I and II, 3 for the rest
    assert len(seeds.questions) >= 3
    assert judges.episodes >= 100
    assert judges.stock_episodes <= judges.episodes
    read_section(ImitationParams, "imitate", PARAMS)
