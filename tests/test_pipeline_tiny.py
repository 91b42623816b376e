"""All stages end to end at a tiny size; through DVC; killed in the middle and resumed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from lfr.artifacts import read_json
from lfr.data.log_reader import list_logs, read_log
from lfr.evaluation.records import CHAIN
from lfr.mapping.saved_generators import load_mapping_seen
from lfr.params import read_yaml
from lfr.skills.demonstrations import read_demonstrations
from lfr.skills.saved_models import load_seen

from . import tiny_project

STAGES = ("record", "pack", "skills", "mapping", "transfer", "evaluate")
TRANSFER, RUN = "s1-panda-lift", "s1-panda-lift-lfr"


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tiny project after all its stages, run in this process; do not write to it."""
    return tiny_project.run_stages(tmp_path_factory.mktemp("tiny"))


def test_every_stage_leaves_its_metrics_and_outs(project: Path) -> None:
    for stage in STAGES:
        files = sorted((project / "results" / stage).glob("*.json"))
        assert files
        runs = [read_json(file) for file in files]
        assert all(run["seconds"] > 0 and run["peak_memory"] > 2**20 for run in runs)
        assert all(run["provenance"]["packages"]["mujoco"] for run in runs)
    datasets = {f"{robot}-{task}" for robot in ("panda", "sawyer")
                for task in ("lift", "pick_place", "nut_assembly")}  # fmt: skip
    assert {path.name for path in (project / "data/lerobot").iterdir()} == datasets
    assert {path.name for path in (project / "data/logs").iterdir()} == datasets
    for name in ("transfers.json", "chain.json", "table.json", "table.md", "report.md",
                 "learning.svg"):  # fmt: skip
        assert (project / "results" / name).stat().st_size > 0


def test_the_record_of_the_run(project: Path) -> None:
    (record,) = read_json(project / "results/transfers.json")
    params = read_yaml(project / "params.yaml")
    assert (record["transfer"], record["method"], record["seed"]) == (TRANSFER, "lfr", 0)
    assert record["env_steps"] >= params["transfer"]["steps"]
    assert record["episodes"] == params["evaluate"]["episodes"]
    assert record["judge"] == "engine"
    assert list(record["other_judges"]) == ["robosuite"]
    assert record["reward"] == "sparse"
    chain = read_json(project / "results/chain.json")[TRANSFER]
    assert tuple(chain["zero_shot"]) == tuple(link for link in CHAIN if link != "retarget")
    assert all(link["episodes"] == 4 for link in chain["zero_shot"].values())


def test_no_model_but_the_oracle_has_seen_the_targets_new_task(project: Path) -> None:
    hidden = "panda-lift"
    skills = project / "models/skills"
    folders = [path.parent for path in skills.rglob("config.json")]
    seen = {folder.relative_to(skills).as_posix(): load_seen(folder) for folder in folders}
    common = ("pick_place", "nut_assembly")
    source, target = "sawyer/lift+nut_assembly+pick_place", "panda/nut_assembly+pick_place"
    oracle = "panda/lift+nut_assembly+pick_place"
    assert set(seen) == {
        f"{source}/vae", f"{source}/prior-pick_place", f"{source}/prior-nut_assembly",
        f"{source}/prior-lift",
        f"{target}/vae", f"{target}/prior-pick_place", f"{target}/prior-nut_assembly",
        f"{oracle}/vae", f"{oracle}/prior-lift",
    }  # fmt: skip
    assert set(seen[f"{target}/vae"].tasks) == set(common)
    assert set(seen[f"{source}/vae"].tasks) == {*common, "lift"}
    for name, one in seen.items():
        assert (hidden in one.datasets) == name.startswith(oracle)
        assert set(one.datasets) == {f"{one.robot}-{task}" for task in one.tasks}
    for name in ("g", "f"):
        mapping = load_mapping_seen(project / "models/mapping" / TRANSFER / name)
        assert mapping.tasks == common
        assert mapping.skills == (source, target)
        assert hidden not in mapping.datasets
    (record,) = read_json(project / "results/transfers.json")
    assert hidden not in record["revisions"]["datasets"]


def test_what_a_model_says_it_has_seen_is_what_is_there(project: Path) -> None:
    seen = load_seen(project / "models/skills/sawyer/lift+nut_assembly+pick_place/vae")
    for task in seen.tasks:
        path = project / "data/lerobot" / f"{seen.robot}-{task}"
        found = read_demonstrations(
            path, seen.robot, task, horizon=10, held_out=0.34, seed=0
        )  # as trained
        assert found.digest == seen.datasets[found.dataset]
        assert len(found.training.actions) > len(found.held_out.actions) > 0
        assert not found.training.is_pad.any()
        # The last skill of a demonstration lies beyond its success, whole.
        total = len(found.training_states) + len(found.held_out_states)
        assert len(found.training.actions) + len(found.held_out.actions) == total - 3 * 9


def test_a_run_can_be_looked_at(project: Path) -> None:
    folder = project / "models/transfer" / RUN / "seed-0"
    assert {path.name for path in folder.iterdir()} == {
        "config.json", "model.safetensors", "initial",
    }  # fmt: skip
    learning = project / "models/learning" / RUN / "seed-0"
    policies = sorted(path.name for path in learning.glob("policy-*"))
    assert {path.name for path in learning.iterdir()} == {"curve.csv", "updates.csv", *policies}
    assert policies[0] == "policy-000000"
    assert len(policies) == 3
    for name, other in ((policies[0], folder / "initial"), (policies[-1], folder)):
        tensors = (learning / name / "model.safetensors").read_bytes()
        assert tensors == (other / "model.safetensors").read_bytes()
    header, *rows = (project / "results/transfer" / f"{RUN}.csv").read_text().splitlines()
    assert header.startswith("seed,env_steps,")
    assert rows[0].startswith("0,0,")
    assert len(rows) >= 3
    ours = (learning / "curve.csv").read_text().splitlines()
    assert [f"seed,{ours[0]}", *(f"0,{row}" for row in ours[1:])] == [header, *rows]
    recordings = project / "recordings" / RUN / "seed-0"
    assert {path.name for path in recordings.iterdir()} == {
        "learning.rrd", *(f"{name.replace('policy', 'episode')}.rrd" for name in policies),
    }  # fmt: skip


@pytest.mark.slow
def test_dvc_runs_the_same_and_nothing_twice(project: Path, tmp_path: Path) -> None:
    """Jobs in a pool of processes, stages in an order of DVC's: the same results, bit for bit."""
    folder = tiny_project.make(tmp_path / "repro")
    tiny_project.run(folder, "dvc", "repro")
    _assert_same(project, folder)
    before = {path: path.stat().st_mtime_ns for path in (folder / "results").rglob("*.*")}
    printed = tiny_project.run(folder, "dvc", "repro").stdout
    assert "Data and pipelines are up to date." in printed
    assert "Running stage" not in printed
    assert {path: path.stat().st_mtime_ns for path in (folder / "results").rglob("*.*")} == before
    shown = tiny_project.run(folder, "dvc", "metrics", "show", "--json").stdout
    assert RUN in json.dumps(json.loads(shown))


@pytest.mark.slow
def test_a_ray_node_gives_the_same(project: Path, tmp_path: Path, ray_address: str) -> None:
    folder = tiny_project.make(tmp_path / "cluster")
    tiny_project.run(folder, "dvc", "repro", RAY_ADDRESS=ray_address)
    _assert_same(project, folder)


@pytest.mark.slow
def test_killed_at_several_moments_and_resumed(project: Path, tmp_path: Path) -> None:
    """kill -9 while each stage works: the same results, and no finished job is run again."""
    folder = tiny_project.make(tmp_path / "killed")
    moments = [
        "work/record/panda-lift/*/*.json",
        "data/lerobot/.partial-sawyer-lift",
        "work/skills/panda/*/models/panda/nut_assembly+pick_place/vae/config.json",
        f"work/mapping/{TRANSFER}/*/*.json",
        f"work/transfer/{RUN}/*/seed-0/checkpoints/*/config.json",
        f"work/evaluate/{RUN}/*/*.json",
    ]
    finished: dict[Path, int] = {}
    for moment in moments:
        tiny_project.kill_when(folder, moment, "dvc", "repro")
        for path, written in finished.items():
            assert path.stat().st_mtime_ns == written, f"{path} was made again"
        finished |= {path: path.stat().st_mtime_ns for path in tiny_project.finished(folder)}
        for out in ("data/logs", "data/lerobot", "models/skills", "results"):
            names = [path.name for path in (folder / out).rglob("*")]
            assert not [name for name in names if name.endswith(".partial")]
    tiny_project.run(folder, "dvc", "repro")
    for path, written in finished.items():
        assert path.stat().st_mtime_ns == written, f"{path} was made again"
    _assert_same(project, folder)


def _assert_same(one: Path, other: Path) -> None:
    for stage in STAGES:
        for file in sorted((one / "results" / stage).glob("*.json")):
            again = other / file.relative_to(one)
            found, expected = (tiny_project.lasting(read_json(each)) for each in (again, file))
            assert found == expected, file.name
    for name in (f"results/transfer/{RUN}.csv", "results/chain.json", "results/table.md"):
        assert (other / name).read_bytes() == (one / name).read_bytes()
    for pattern in ("model.safetensors", "*.csv"):
        for file in sorted((one / "models").rglob(pattern)):
            assert (other / file.relative_to(one)).read_bytes() == file.read_bytes()
    for log in list_logs(one / "data/logs/panda-lift"):
        first, second = read_log(log), read_log(other / log.relative_to(one))
        assert np.array_equal(first.simulator_state, second.simulator_state)
        for key, column in first.features.items():
            assert np.array_equal(column, second.features[key])
