"""The leak rule: the source's demonstrations of the new task, and no others."""

from pathlib import Path

import pytest
import torch

from lfr.artifacts import read_json
from lfr.errors import DataError, LfrError
from lfr.scenarios import Scenario
from studies.imitation import cloning
from studies.imitation.cloning import ImitationJob, fit_imitation, imitation_seed
from studies.imitation.saved_policies import load_seen
from tests.studies.imitation.made_up import SMALL, demonstrations

SCENARIO = Scenario("s1", ("pick_place", "nut_assembly"), {"panda": "lift", "sawyer": "stack"})


def job(robot: str, task: str, folder: Path, seed: int = 0) -> ImitationJob:
    return ImitationJob(
        SCENARIO, robot, task, SMALL, 0.25, seed, str(folder / "policy"), str(folder / "data")
    )


@pytest.mark.parametrize(("robot", "task"), [("panda", "lift"), ("sawyer", "stack")])
def test_the_targets_own_demonstrations_are_refused(
    robot: str, task: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def read(*_: object) -> None:
        raise AssertionError("it was read")

    monkeypatch.setattr(cloning, "read_recorded", read)
    with pytest.raises(LfrError, match=f"'{task}' by {robot} are hidden.*'source'"):
        fit_imitation(job(robot, task, tmp_path))
    assert not list(tmp_path.iterdir())


def test_a_dataset_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"no such dataset.*sawyer-lift"):
        fit_imitation(job("sawyer", "lift", tmp_path))


def test_it_sees_the_training_episodes_of_one_dataset(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorded = demonstrations((8, 9, 10, 11))
    told = {}

    def train(training: object, *rest: object) -> object:
        told["training"] = training
        return original(training, *rest)  # type: ignore[arg-type]

    original = cloning.train_bc
    monkeypatch.setattr(cloning, "read_recorded", lambda *_: recorded)
    monkeypatch.setattr(cloning, "train_bc", train)
    one = job("sawyer", "lift", tmp_path)
    one.dataset.joinpath("data").mkdir(parents=True)
    found = fit_imitation(one)
    training, _ = recorded.split(0.25, 0)
    assert torch.equal(told["training"].observations, training.observations)
    seen = load_seen(Path(one.folder))
    assert (seen.robot, seen.tasks) == ("sawyer", ("lift",))
    assert list(seen.datasets) == list(found["datasets"]) == ["sawyer-lift"]
    assert found["updates"] == SMALL.updates
    assert read_json(Path(one.folder) / "config.json")["model"]["horizon"] == SMALL.horizon


def test_no_two_seeds_start_from_the_same_weights(tmp_path: Path) -> None:
    jobs = [job("sawyer", "lift", tmp_path, seed) for seed in range(5)]
    assert len({imitation_seed(one) for one in jobs}) == len(jobs)
