"""Curves of a learning run, from disk and live."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from lfr.errors import DataError
from lfr.transfer.observer import CurvePoint
from lfr.view.curve import read_curve, save_learning
from lfr.view.learning import LearningLog

from . import rrd

CURVE = [
    {"env_steps": 0, "success": 0.25, "kl": None, "q": None},
    {"env_steps": 5000, "success": 0.5, "kl": 1.5, "q": 0.2},
    {"env_steps": 10000, "success": 0.75, "kl": 1.25, "q": 0.3},
]


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


def test_a_run_is_logged_while_it_learns(tmp_path: Path) -> None:
    sampled: list[int] = []
    log = LearningLog(tmp_path / "learning.rrd", "run", sampled.append, samples=(0.0, 0.5, 1.0))
    log.on_evaluation(point(0, 0.1))
    for round_ in range(1, 101):
        log.on_update(round_ * 10, round_, {"kl": 0.01 * round_, "alpha": 0.1})
        log.on_progress(round_ * 10, 1000)
        if round_ % 20 == 0:
            log.on_evaluation(point(round_ * 10, round_ / 100))
    log.catch_up([{"env_steps": 400, "success": 9.0}])  # heard of already
    log.close()
    assert sampled == [0, 600, 1000]  # the first evaluation at or after each fraction
    entities = rrd.read(tmp_path / "learning.rrd")
    steps, kl = entities["/update/kl"]["Scalars:scalars"]
    order = np.argsort(steps if steps is not None else [])
    np.testing.assert_allclose(np.ravel(kl)[order], 0.01 * np.arange(1, 101))
    success = np.ravel(entities["/evaluation/success"]["Scalars:scalars"][1])
    assert sorted(success) == [0.1, 0.2, 0.4, 0.6, 0.8, 1.0]


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


def test_a_resumed_run_has_the_means_of_what_it_did_not_hear(tmp_path: Path) -> None:
    log = LearningLog(tmp_path / "learning.rrd", "run")
    log.catch_up(CURVE[:2])
    log.on_update(7500, 9, {"kl": 2.0})
    log.on_evaluation(point(10000, 0.75))
    log.catch_up(CURVE)  # its last point was heard of, and with it every update before it
    log.close()
    steps, kl = rrd.read(tmp_path / "learning.rrd")["/update/kl"]["Scalars:scalars"]
    assert sorted(zip(list(steps if steps is not None else ()), np.ravel(kl), strict=True)) == [
        (5000, 1.5), (7500, 2.0),
    ]  # fmt: skip
