"""paper/dvc.yaml end to end at a tiny size, through DVC; one more seed; killed and resumed."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dvc.repo import Repo

from lfr.artifacts import read_json
from lfr.data.episode import ACTION
from lfr.data.log_reader import read_log
from lfr.evaluation.evidence.records import read_evidence
from lfr.evaluation.evidence.reference import BENCHMARK
from lfr.params import read_yaml
from lfr.skills.artifacts import load_vae

from .. import tiny_project

pytestmark = pytest.mark.slow
PIPELINE, TRANSFER = "paper/dvc.yaml", "s1-panda-lift"
LFR = f"{TRANSFER}-lfr"
PAPER = Path("results/paper")
REPRO = ("dvc", "repro", PIPELINE)
SEED = 2  # the one that comes later


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tiny evidence of two seeds after all its stages; do not write to it."""
    root = tmp_path_factory.mktemp("evidence")
    folder = tiny_project.make(root / "two-seeds", pipeline=PIPELINE)
    shutil.copy(Path(__file__).with_name("tiny_params.yaml"), folder / "paper/params.yaml")
    shutil.copy(tiny_project.ROOT / BENCHMARK, folder / BENCHMARK)
    tiny_project.run_demonstrations(folder)
    tiny_project.run(folder, *REPRO)
    return folder


@pytest.fixture(scope="module")
def three_seeds(project: Path) -> Path:
    """A copy of it after one more seed in the tables."""
    folder = _with_another_seed(project, "three-seeds")
    tiny_project.run(folder, *REPRO)
    return folder


def test_all_results_are_there(project: Path) -> None:
    with Repo(str(project)) as repo:
        outs = [Path(out.fs_path) for stage in repo.index.stages for out in stage.outs]
    assert {out.relative_to(project).parts[0] for out in outs} == {"data", "models", "results"}
    assert len(outs) == len(set(outs)) > 30
    assert [out for out in outs if not out.exists()] == []
    assert [out for out in outs if out.is_file() and not out.stat().st_size] == []


def test_every_method_has_a_run_of_every_seed_and_reward(project: Path) -> None:
    """As paper/params.yaml plans it, all for as many steps, judged on as many starts."""
    plan = read_yaml(project / "paper/params.yaml")
    wanted = {
        (method, reward, seed)
        for group, methods in plan["learn"]["methods"].items()
        for method in methods
        for reward in plan["learn"]["rewards"][group]
        for seed in plan["seeds"]["tables" if group == "tables" else "questions"]
    } | {("bc_rnn", None, seed) for seed in plan["seeds"]["tables"]}
    evidence = read_evidence(project / PAPER)
    assert {(run.method, run.reward, run.seed) for run in evidence.runs} == wanted
    steps = read_yaml(project / "params.yaml")["transfer"]["steps"]
    assert all(run.episodes == plan["judging"]["episodes"] for run in evidence.runs)
    learned = [run for run in evidence.runs if run.method != "bc_rnn"]
    assert all(steps <= (run.env_steps or 0) < steps + 100 for run in learned)
    assert {len(seeds.rates) for seeds in evidence.links[TRANSFER].links.values()} == {1, 2}
    assert all(run.stock is not None for run in evidence.runs)


def test_both_rewards_and_all_methods_start_alike(project: Path) -> None:
    """The first point of a curve is before learning: for each seed the same under both rewards."""
    for method in ("lfr", "ap", "sac"):
        first = [row for row in _rows(project, f"{TRANSFER}-{method}") if row["env_steps"] == "0"]
        for seed in ("0", "1"):
            lengths = {row["mean_length"] for row in first if row["seed"] == seed}
            assert len(lengths) == 1
    models = {run["seed"]: run["models"] for run in _learned(project, LFR)["runs"]}
    for method in ("ap", "sac"):
        runs = _learned(project, f"{TRANSFER}-{method}")["runs"]
        assert {run["seed"]: run["models"] for run in runs} == models


def test_the_reference_goes_to_its_end(project: Path) -> None:
    rows = _read(project / PAPER / "reference/lift-panda.csv")
    seeds = {str(seed) for seed in read_yaml(project / "paper/params.yaml")["seeds"]["questions"]}
    assert {row["seed"] for row in rows} == seeds
    for seed in seeds:
        steps = [int(row["env_steps"]) for row in rows if row["seed"] == seed]
        assert steps[0] == 0
        assert steps == sorted(set(steps))
        assert steps[-1] >= 300


def test_plain_links_are_of_their_own_models_and_demonstrations(project: Path) -> None:
    """As many starts as ours, whole skills, logs undisturbed and without pictures."""
    plan, evidence = read_yaml(project / "paper/params.yaml"), read_evidence(project / PAPER)
    plain = evidence.plain[TRANSFER]
    assert list(plain.links) == ["own_arm", "oracle", "identity", "recoded", "mapped"]
    assert set(plain.seeds.values()) == {tuple(plan["seeds"]["questions"])}
    judged = {count for link in plain.links.values() for count in link.episodes}
    assert judged == {plan["judging"]["episodes"]}
    for kind, group, executed in (("paper", "tables", 5), ("paper-plain", "questions", 10)):
        vaes = sorted((project / "models" / kind / TRANSFER).glob("seed-*/skills/*/vae"))
        assert len(vaes) == 3 * len(plan["seeds"][group])
        assert {load_vae(vae).execute for vae in vaes} == {executed}
    for kind, disturbed in (("data", True), ("data/paper-plain", False)):
        (log, *_) = sorted((project / kind / "logs/panda-lift").glob("*.mcap"))
        episode = read_log(log)
        assert episode.executed_action is not None
        same = np.allclose(episode.features[ACTION], episode.executed_action, atol=1e-6)
        assert same is not disturbed
        assert bool(episode.images) <= disturbed


def test_who_learns_from_plain_models_begins_as_their_links_say(project: Path) -> None:
    evidence = read_evidence(project / PAPER)
    plain = evidence.plain[TRANSFER]
    begun = {
        method: [one.zero_shot for one in evidence.plain_runs if one.method == method]
        for method in ("lfr", "ap")
    }
    assert begun == {
        "lfr": list(plain.links["mapped"].rates), "ap": list(plain.links["identity"].rates)
    }  # fmt: skip
    (file,) = (project / PAPER / "learn").glob(f"{TRANSFER}-lfr.json")
    (plain_file,) = (project / PAPER / "learn_plain").glob(f"{TRANSFER}-lfr.json")
    ours, theirs = ({run["models"] for run in read_json(f)["runs"]} for f in (file, plain_file))
    assert ours
    assert theirs
    assert not ours & theirs


def test_plain_imitation_is_of_plain_demonstrations(project: Path) -> None:
    ours, plain, models = (
        read_json(project / PAPER / f"{stage}/{TRANSFER}.json")
        for stage in ("imitate", "imitate_plain", "plain")
    )
    questions = read_yaml(project / "paper/params.yaml")["seeds"]["questions"]
    assert [run["seed"] for run in plain["runs"]] == questions
    assert ours["datasets"].keys() == plain["datasets"].keys() == {"sawyer-lift"}
    assert ours["datasets"] != plain["datasets"]
    known = models["runs"][0]["skills"]["source"]["datasets"]
    assert plain["datasets"].items() <= known.items()
    policies = project / f"models/paper-plain-imitators/{TRANSFER}"
    assert {folder.name for folder in policies.iterdir()} == {f"seed-{n}" for n in questions}


def test_parts_leave_all_else_as_it_was(project: Path) -> None:
    """Where a set of choices touches no model of a link, the link is that of the other stage."""
    parts = read_evidence(project / PAPER).parts[TRANSFER]
    every = {"demonstrations", "execute", "vae", "prior", "mapping"}
    names = {"mapping": {"mapping"}, "all_but_execute": every - {"execute"}}
    assert [set(set_back) for set_back in parts] == [names["all_but_execute"], names["mapping"]]
    found = {
        name: read_json(project / PAPER / f"plain_parts/{TRANSFER}-{name}.json") for name in names
    }
    ours = read_json(project / PAPER / f"zero_shot/{TRANSFER}.json")["links"]
    (seed,) = read_yaml(project / "paper/params.yaml")["seeds"]["questions"]
    links = found["mapping"]["links"]
    for link in ("own_arm", "identity", "recoded", "oracle"):
        same = [run for run in ours[link]["runs"] if run["seed"] == seed]
        assert links[link]["runs"] == same
    trained = {name: _trained(content) for name, content in found.items()}
    models, plain = (
        _trained(read_json(project / PAPER / f"{stage}/{TRANSFER}.json"))
        for stage in ("models", "plain")
    )
    assert trained["mapping"]["skills"] == models["skills"]
    assert trained["mapping"]["mapping"] != models["mapping"]
    # How much is carried out changes neither VAE nor prior, but what they are asked for.
    assert trained["all_but_execute"]["skills"] == plain["skills"] != models["skills"]
    executed = {
        load_vae(vae).execute
        for vae in project.glob(f"work/paper-plain-parts/{TRANSFER}-all_but_execute/*/models/"
                                "seed-*/skills/*/vae")
    }  # fmt: skip
    assert executed == {5}


def _trained(content: dict[str, Any]) -> dict[str, Any]:
    """What a stage says of the first seed's models."""
    run = min(content["runs"], key=lambda run: run["seed"])
    return {"skills": run["skills"], "mapping": run["mapping"]}


def test_a_second_time_nothing_runs(project: Path) -> None:
    before = _written(project / "results")
    printed = tiny_project.run(project, *REPRO).stdout
    assert "Data and pipelines are up to date." in printed
    assert "Running stage" not in printed
    assert _written(project / "results") == before


def test_another_seed_runs_its_own_jobs_alone(project: Path, three_seeds: Path) -> None:
    before, after = _jobs(project), _jobs(three_seeds)
    for name, written in before.items():
        assert after[name] == written, f"{name} was made again"
    stages = {"paper-models", "paper-zero-shot", "paper-imitate", "paper-learn"}
    new = after.keys() - before.keys()
    assert {name.parts[1] for name in new} == stages
    for name in new:
        text = (three_seeds / name).read_text()
        assert f"seed-{SEED}" in text or f'"seed": {SEED}' in text, name
    for method in ("lfr", "ap", "sac"):
        old, rows = (_rows(folder, f"{TRANSFER}-{method}") for folder in (project, three_seeds))
        assert [row for row in rows if row["seed"] != str(SEED)] == old
        assert {row["reward"] for row in rows if row["seed"] == str(SEED)} == {"sparse", "dense"}
    for name in ("spirl", "no_generator"):
        assert _rows(three_seeds, f"{TRANSFER}-{name}") == _rows(project, f"{TRANSFER}-{name}")


def test_killed_while_it_learns_and_resumed(project: Path, three_seeds: Path) -> None:
    """kill -9 between two checkpoints: the same curves as of a run that nobody disturbed."""
    folder = _with_another_seed(project, "killed")
    command = "dvc", "repro", f"{PIPELINE}:learn@{LFR}"
    middle = f"work/paper-learn/{LFR}/*/*-seed-{SEED}-*/checkpoints/*/config.json"
    tiny_project.kill_when(folder, middle, *command)
    left = set(_jobs(three_seeds)) - set(_jobs(folder))
    assert len([name for name in left if name.parts[1:3] == ("paper-learn", LFR)]) > 1
    assert not (folder / PAPER / f"learn/{LFR}.json").exists()
    before = _written(folder / "work/paper-models")
    tiny_project.run(folder, *command)
    assert _written(folder / "work/paper-models") == before
    again, whole = (each / PAPER / f"learn/{LFR}.csv" for each in (folder, three_seeds))
    assert again.read_bytes() == whole.read_bytes()
    found, expected = (tiny_project.lasting(_learned(each, LFR)) for each in (folder, three_seeds))
    assert found == expected


def test_the_reference_is_killed_and_resumed(project: Path) -> None:
    folder = project.with_name("reference")
    shutil.copytree(project, folder, symlinks=True)
    shutil.rmtree(folder / "work/paper-reference")
    command = "dvc", "repro", "--single-item", "--force", f"{PIPELINE}:reference"
    middle = "work/paper-reference/*/*/seed-*/checkpoints/*/config.json"
    tiny_project.kill_when(folder, middle, *command)
    name = PAPER / "reference/lift-panda.csv"
    assert not (folder / name).exists()
    tiny_project.run(folder, *command)
    assert (folder / name).read_bytes() == (project / name).read_bytes()
    assert not list((folder / "work/paper-reference").rglob("checkpoints"))


def _with_another_seed(project: Path, name: str) -> Path:
    folder = project.with_name(name)
    shutil.copytree(project, folder, symlinks=True)
    params = folder / "paper/params.yaml"
    text = params.read_text()
    assert "tables: [0, 1]" in text
    params.write_text(text.replace("tables: [0, 1]", f"tables: [0, 1, {SEED}]"))
    return folder


def _jobs(folder: Path) -> dict[Path, int]:
    return {p.relative_to(folder): p.stat().st_mtime_ns for p in tiny_project.finished(folder)}


def _written(folder: Path) -> dict[Path, int]:
    return {path: path.stat().st_mtime_ns for path in folder.rglob("*.*")}


def _rows(folder: Path, name: str) -> list[dict[str, str]]:
    return _read(folder / PAPER / f"learn/{name}.csv")


def _read(file: Path) -> list[dict[str, str]]:
    with file.open(newline="") as stream:
        return list(csv.DictReader(stream))


def _learned(folder: Path, name: str) -> dict[str, Any]:
    return read_json(folder / PAPER / f"learn/{name}.json")
