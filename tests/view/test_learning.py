"""Curves of learning runs, and what else they leave, drawn at the end and on the way."""

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from lfr.errors import DataError
from lfr.transfer.log import LearningLog
from lfr.transfer.observer import CurvePoint
from lfr.view.curve import read_curve, save_learning
from lfr.view.learning import RunRecordings, save_run
from lfr.view.recordings import Wanted, recordings

from . import rrd
from .made_up import made_up_actor

CURVE = [
    {"env_steps": 0, "success": 0.25, "kl": None, "q": None},
    {"env_steps": 5000, "success": 0.5, "kl": 1.5, "q": 0.2},
    {"env_steps": 10000, "success": 0.75, "kl": 1.25, "q": 0.3},
]

ABOUT = {
    "robot": "panda", "task": "lift", "seed": 0, "transfer": "s1-panda-lift", "method": "lfr",
}  # fmt: skip


def point(env_steps: int, success: float) -> CurvePoint:
    return CurvePoint(
        env_steps, 0, 0, success, 0.0, 10.0, None, None, None, None, None, None, None
    )  # fmt: skip


@pytest.mark.parametrize("suffix", [".json", ".csv"])
def test_a_curve_is_read_and_shown(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"curve{suffix}"
    if suffix == ".json":
        path.write_text(json.dumps({"curve": CURVE}))
    else:
        with path.open("w", newline="") as stream:
            writer = csv.DictWriter(stream, list(CURVE[0]))
            writer.writeheader()
            writer.writerows(CURVE)
    save_learning(tmp_path / "learning.rrd", read_curve(path), "run")
    entities = rrd.read(tmp_path / "learning.rrd")
    steps, success = entities["/evaluation/success"]["Scalars:scalars"]
    assert list(steps if steps is not None else ()) == [0, 5000, 10000]
    assert np.ravel(success).tolist() == [0.25, 0.5, 0.75]
    steps, kl = entities["/update/kl"]["Scalars:scalars"]
    assert list(steps if steps is not None else ()) == [5000, 10000]
    assert np.ravel(kl).tolist() == [1.5, 1.25]


def test_a_foreign_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "curve.json"
    path.write_text('[{"steps": 3}]')
    with pytest.raises(DataError, match=r"curve\.json.*env_steps"):
        read_curve(path)


def test_seeds_are_a_curve_each(tmp_path: Path) -> None:
    path = tmp_path / "runs.csv"
    rows = ["seed,env_steps,success,kl", "3,0,0.25,", "3,500,0.5,1.5", "7,0,0.0,", "7,510,1.0,2.5"]
    path.write_text("\n".join(rows))
    save_learning(tmp_path / "learning.rrd", read_curve(path), "runs")
    entities = rrd.read(tmp_path / "learning.rrd")
    for seed, steps, success in ((3, [0, 500], [0.25, 0.5]), (7, [0, 510], [0.0, 1.0])):
        found, values = entities[f"/evaluation/success/seed-{seed}"]["Scalars:scalars"]
        assert list(found if found is not None else ()) == steps
        assert np.ravel(values).tolist() == success
        names = entities[f"/evaluation/success/seed-{seed}"]["SeriesLines:names"][1][0]
        assert names == [f"seed {seed}, evaluation"]
    assert "Scalars:scalars" not in entities.get("/evaluation/success", {})
    assert np.ravel(entities["/update/kl/seed-7"]["Scalars:scalars"][1]).tolist() == [2.5]


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run under way: it has been evaluated once and has left a policy."""
    folder = tmp_path / "work/transfer/s1-panda-lift-lfr/0123/seed-0/learning"
    log = LearningLog(folder, made_up_actor(), ABOUT)
    log.on_evaluation(point(0, 0.1))
    log.on_update(40, 3, {"critic_loss": 0.5})
    return folder


def values(file: Path, entity: str) -> dict[int, float]:
    steps, found = rrd.read(file)[entity]["Scalars:scalars"]
    return dict(zip(list(steps if steps is not None else ()), np.ravel(found), strict=True))


def test_a_run_is_drawn_as_it_goes_on(run: Path, tmp_path: Path) -> None:
    runs = RunRecordings(run.parents[1], tmp_path / "out")
    learning, first = runs.look()
    assert (learning.name, first.name) == ("learning.rrd", "episode-000000.rrd")
    assert "/world/cube_main" in rrd.read(first)
    assert runs.look() == []
    log = LearningLog(run, made_up_actor(), ABOUT)
    log.on_update(80, 6, {"critic_loss": 0.25, "kl": 1.5})
    log.on_progress(100, 100)
    log.on_evaluation(point(100, 0.75))
    assert [file.name for file in runs.look()] == ["episode-000100.rrd"]
    runs.close()
    assert values(learning, "/evaluation/success") == {0: 0.1, 100: 0.75}
    assert values(learning, "/update/critic_loss") == {40: 0.5, 80: 0.25}
    assert values(learning, "/update/kl") == {80: 1.5}
    name = rrd.read(learning)["/__properties"]["RecordingInfo:name"][1][0][0]
    assert name == "learning · s1-panda-lift lfr seed 0"


def test_a_run_is_found_by_where_its_policy_will_be(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shown = recordings(Path("models/transfer/s1-panda-lift-lfr"), tmp_path / "out", Wanted())
    assert [file.name for file in shown.files] == ["learning.rrd", "episode-000000.rrd"]
    assert shown.learning is not None


def test_what_is_made_already_is_shown_beside_the_policy(run: Path, tmp_path: Path) -> None:
    place = "s1-panda-lift-lfr/seed-0"
    shutil.copytree(run, tmp_path / "models/learning" / place)
    shutil.copytree(run / "policy-000000", policy := tmp_path / "models/transfer" / place)
    shown = recordings(policy, tmp_path / "out", Wanted(seed=3))
    names = ["policy-seed-3.rrd", "learning.rrd", "episode-000000.rrd"]
    assert [file.name for file in shown.files] == names
    made = save_run(tmp_path / "models/learning" / place, tmp_path / "recordings" / place)
    again = recordings(policy, tmp_path / "again", Wanted(seed=3))
    assert again.files[1:] == made
    assert again.learning is None


def test_no_run_is_told(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"missing.*curve\.csv"):
        save_run(tmp_path, tmp_path / "out")
