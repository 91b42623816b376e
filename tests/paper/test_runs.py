"""Which run is which: its folder is named after all that it depends on; and what judges it."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from lfr.errors import DataError, LfrError
from lfr.params import from_mapping
from lfr.scenarios import Transfer
from lfr.transfer.params import TransferParams
from pipeline.paper._runs import PaperRun, judgements, paper_run
from pipeline.paper._stage import MODELS, VARIANTS, Judging
from pipeline.paper.learn_plain import PlainLearning

TRANSFER = Transfer("s-b-new", "s", "a", "b", ("lift",), "new")


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two seeds with one file of models and one of variants each."""
    monkeypatch.chdir(tmp_path)
    for seed in (0, 1):
        _write(MODELS, f"seed-{seed}/skills/source/vae/model", f"models {seed}")
        _write(VARIANTS, f"seed-{seed}/shared_vae/vae/model", f"variants {seed}")
    return tmp_path


def _write(root: Path, name: str, text: str) -> None:
    file = root / TRANSFER.name / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)


def _run(
    seed: int = 0, params: TransferParams | None = None, *, variants: bool = False
) -> PaperRun:
    params = params or TransferParams()
    method = "shared_vae" if variants else "lfr"
    return paper_run(TRANSFER, method, seed, params, Path("work"))


def test_a_runs_folder_says_reward_and_seed(project: Path) -> None:
    dense = TransferParams(reward="dense")
    assert _run().folder.name.startswith("sparse-seed-0-")
    assert _run(1, dense).folder.name.startswith("dense-seed-1-")
    assert _run().folder.parent == Path("work")
    assert _run() == _run()


@pytest.mark.parametrize("changed", [{"steps": 1}, {"critic_hidden": (8,)}, {"fixed_alpha": True}])
def test_other_parameters_are_another_run(project: Path, changed: dict) -> None:
    other = dataclasses.replace(TransferParams(), **changed)
    assert _run(params=other).folder != _run().folder


def test_other_models_are_another_run_of_their_seed_alone(project: Path) -> None:
    before = [_run(0), _run(1)]
    _write(MODELS, "seed-1/skills/source/vae/model", "trained again")
    after = [_run(0), _run(1)]
    assert after[0] == before[0]
    assert after[1].folder != before[1].folder
    _write(MODELS, "seed-1/skills/source/vae/model", "models 1")
    assert [_run(0), _run(1)] == before


def test_variants_matter_to_those_that_start_from_them_alone(project: Path) -> None:
    table, question = _run(), _run(variants=True)
    _write(VARIANTS, "seed-0/shared_vae/vae/model", "a new one")
    assert _run() == table
    changed = _run(variants=True)
    assert changed.folder != question.folder
    _write(VARIANTS, "seed-0/linear/g/model", "that no run starts from")
    assert _run(variants=True) == changed


def test_another_seed_leaves_the_runs_there_are(project: Path) -> None:
    before = _run(), _run(variants=True)
    for root in (MODELS, VARIANTS):
        _write(root, "seed-2/model", "one more")
    assert (_run(), _run(variants=True)) == before


def test_missing_models_are_named(project: Path) -> None:
    with pytest.raises(DataError, match=r"missing: models/paper/s-b-new/seed-7"):
        _run(7)


def test_a_run_is_judged_by_both_judges_on_the_targets_task(project: Path) -> None:
    run = _run()
    shards = judgements(run, Judging(episodes=60, stock_episodes=10), zero_shot=True)
    starts = {
        name: [start for found, one in shards if found == name
               for start in range(one.first, one.first + one.episodes)]
        for name, _ in shards
    }  # fmt: skip
    # The same held-out starts for every policy; stock robosuite judges the first of them again.
    assert starts == {name: list(range(count)) for name, count in
                      (("engine", 60), ("robosuite", 10), ("zero_shot", 60))}  # fmt: skip
    for name, one in shards:
        assert (one.robot, one.task) == ("b", "new")
        assert one.judge == ("robosuite" if name == "robosuite" else "engine")
        policy = "initial" if name == "zero_shot" else "policy"
        assert vars(one.policy) == {"policy": str(run.folder / policy)}
    without = judgements(run, Judging(episodes=60, stock_episodes=10), zero_shot=False)
    assert without == [shard for shard in shards if shard[0] != "zero_shot"]


def test_models_of_another_root_are_another_run(project: Path) -> None:
    plain = Path("models/paper-plain")
    for seed in (0, 1):
        _write(plain, f"seed-{seed}/skills/source/vae/model", f"plain models {seed}")
    run = paper_run(TRANSFER, "lfr", 0, TransferParams(), Path("work"), plain)
    assert run.root == str(plain)
    assert run.folder != _run().folder


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ({"methods": ["shared_vae"], "rewards": ["sparse"]}, "shared_vae needs shared_vae"),
        ({"methods": ["sca"], "rewards": ["sparse"]}, "unknown method 'sca'"),
        ({"methods": ["ap"], "rewards": []}, "rewards"),
        ({"methods": ["ap"], "rewards": ["sparse"], "transfer": {"reward": "dense"}}, "rewards"),
    ],
)
def test_who_cannot_learn_from_plain_models_is_refused(section: dict, message: str) -> None:
    with pytest.raises(LfrError, match=message):
        from_mapping(PlainLearning, section, "learn_plain")
