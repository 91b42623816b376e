"""The stages skills and mapping on two external arms, without a simulator, and what they give."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from lerobot.datasets import LeRobotDataset
from rerun.experimental import RrdReader

from lfr.artifacts import read_json
from lfr.data.external import read_external
from lfr.data.windows import Windows
from lfr.errors import LfrError
from lfr.external import ExternalArm, external
from lfr.hub.model_card import model_card
from lfr.hub.model_facts import read_models
from lfr.mapping.saved_generators import load_generator, load_mapping_seen
from lfr.scenarios import scenario, transfer
from lfr.seeds import episode_seed
from lfr.skills.compatible import check_arms
from lfr.skills.saved_models import load_prior, load_seen, load_vae
from lfr.skills.skill_policy import SkillPolicy, untranslated
from lfr.transfer.model import load_policy
from tests.external import plane as plane
from tests.view import rrd

from .. import tiny_project
from . import made_up

NAME = "plane-puck-park"
SOURCE, TARGET = "crane/park+pull+push", "puck/pull+push"


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder after all stages, each a process that cannot import this project's simulators."""
    folder = tmp_path_factory.mktemp("theirs")
    made_up.write_both(folder / "data/external", episodes=12)
    (folder / "params.yaml").write_text(made_up.params())
    stages = {
        "skills": ("--robot", "crane"),
        "skills ": ("--robot", "puck"),
        "mapping": ("--transfer", NAME),
        "open_loop": ("--transfer", NAME),
        "transfer": ("--transfer", NAME, "--method", "lfr"),
        "evaluate": ("--transfer", NAME, "--method", "lfr"),
    }
    for stage, options in stages.items():
        code = (
            "import sys; sys.modules.update(mujoco=None, robosuite=None, numba=None)\n"
            f"from lfr.program import run_stage; from pipeline.{stage} import main\n"
            f"sys.argv[1:] = {[*options]}; sys.exit(run_stage(main))"
        )
        ran = subprocess.run(
            [sys.executable, "-c", code], cwd=folder, env=tiny_project.ENVIRONMENT,
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert ran.returncode == 0, ran.stdout + ran.stderr
    return folder


def test_the_leak_rule_holds_for_external_arms(project: Path) -> None:
    skills = project / "models/external-skills"
    source, target = (load_seen(skills / name / "vae") for name in (SOURCE, TARGET))
    assert source.tasks == ("park", "pull", "push")
    assert target.tasks == ("pull", "push")
    assert set(target.datasets) == {"puck-push", "puck-pull"}
    # Nobody has shown the puck how to park, so there is no oracle.
    assert [path.name for path in (skills / "puck").iterdir()] == ["pull+push"]
    mapping = load_mapping_seen(project / "models/mapping" / NAME / "g")
    assert mapping.tasks == ("push", "pull")
    assert mapping.skills == (SOURCE, TARGET)


def test_what_the_actions_stand_for_is_kept_with_the_models(project: Path) -> None:
    seen = load_seen(project / "models/external-skills" / SOURCE / "vae")
    assert seen.actions is not None
    assert seen.actions.names == ("vx", "vy", "hand")
    assert seen.actions.physical(np.array([1.0, -1.0, 0.0])).tolist() == [500, -500, 0.5]


def test_the_reports_say_what_can_be_said_without_a_simulator(project: Path) -> None:
    (model,) = read_json(project / "results/skills/crane.json")["models"].values()
    assert set(model["held_out"]["push"]["rmse"]) == {"vx", "vy", "hand"}
    assert "own_arm" not in model["prior"]["push"]
    (model,) = read_json(project / "results/skills/puck.json")["models"].values()
    assert model["prior"]["push"]["own_arm"]["rate"] == 1.0
    assert "own_arm" not in model["prior"]["pull"]  # of which it has no environment
    mapping = read_json(project / f"results/mapping/{NAME}.json")
    assert mapping["new"]["park"]["decoded_difference"] == {}  # the actions are different things
    for task in mapping["common"].values():  # G and F have learned more than a constant
        assert task["regression_g"] < 0.7 * task["spread_y"]
        assert task["regression_f"] < 0.7 * task["spread_x"]
    assert not (project / "results/chain").exists()


def test_a_mapped_skill_does_on_the_target_what_the_source_would_do(project: Path) -> None:
    """The puck, by the crane's priors through G, moves as its own demonstrator would."""
    skills, mapping = project / "models/external-skills", project / "models/mapping" / NAME
    g, vae = load_generator(mapping / "g"), load_vae(skills / TARGET / "vae")
    for task in ("push", "pull"):
        prior = load_prior(skills / SOURCE / f"prior-{task}")
        policy = SkillPolicy(prior, g.at, vae)
        cosines = []
        for seed in range(100, 120):
            hand, goal, velocity = next(made_up.way(f"{task} it", seed))
            _, speed, cos, sin = policy.act(np.concatenate([hand, goal]))[0]
            assert speed > 0  # more than half of its speed
            wanted = velocity / np.linalg.norm(velocity)
            cosines.append(float(wanted @ [cos, sin]) / float(np.hypot(cos, sin)))
        assert np.mean(cosines) > 0.9


def test_the_open_loop_report_says_how_far_to_trust_it(project: Path) -> None:
    """Its errors are those computed by hand, and it knows where the common tasks never were."""
    folder = project / "results/external" / NAME
    report = read_json(folder / "report.json")
    skills = project / "models/external-skills"
    arm = puck(project)
    vae = load_vae(skills / TARGET / "vae")
    for task, found in report["common"].items():
        _, held_out = read_external(arm, task).split(0.25, 0)
        own = SkillPolicy(load_prior(skills / TARGET / f"prior-{task}"), untranslated, vae)
        windows = Windows(held_out, 5, padded=False).all()
        answers = np.stack([own.act(one) for one in windows.observations.numpy()])  # (N, 3, A)
        errors = np.sqrt(np.square(answers - windows.actions[:, :3].numpy()).mean((0, 1)))
        np.testing.assert_allclose(found["errors"]["own prior"], errors, rtol=1e-4)
        assert set(found["errors"]) == {"mapped", "own prior", "mean action"}  # 3 numbers, and 4
        mapped, mean = (np.linalg.norm(found["errors"][of]) for of in ("mapped", "mean action"))
        assert mapped < 0.7 * mean
        assert found["round_trip"] < 0.3
    assert report["new"]["states_beyond"] > 0.9  # the puck was never shown to go down
    assert set(report["new"]["dimensions_beyond"]) == {"goal_pos.y", "hand_pos.y"}
    page = (folder / "report.md").read_text()
    assert "**park**: 100% of its states lie beyond" in page
    for picture in re.findall(r"!\[.*?\]\((.*?)\)", page):
        assert (folder / picture).read_text().startswith("<?xml")


def puck(project: Path) -> ExternalArm:
    """The arm, with the folders of its datasets in the project."""
    arm = external(project / "params.yaml").arms["puck"]
    tasks = {
        name: replace(task, path=project / (task.path or "")) for name, task in arm.tasks.items()
    }
    return replace(arm, tasks=tasks)


def test_the_mapping_becomes_a_policy_that_acts_in_lerobot(project: Path, tmp_path: Path) -> None:
    """In a process that knows no params.yaml: on the puck's own rows, and in LeRobot's rollout."""
    out = tmp_path / "puck-park"
    told = lfr(project, "export", f"models/mapping/{NAME}", str(out))
    assert "puck can be asked to park; nobody has seen it do so" in told.stdout, told.stderr
    assert "sees observation.state, 4 numbers" in told.stdout
    dataset = project / "data/external/puck-pull"
    script = Path(__file__).with_name("rollout_as_lerobot.py")
    ran = subprocess.run(
        [sys.executable, str(script), str(out), str(dataset), "1"], cwd=tmp_path,
        env=tiny_project.ENVIRONMENT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    found = json.loads(ran.stdout.splitlines()[-1])
    assert "lfr.params" not in found["modules"]

    skills, mapping = project / "models/external-skills", project / "models/mapping" / NAME
    decoder = load_vae(skills / TARGET / "vae")
    policy = SkillPolicy(
        load_prior(skills / SOURCE / "prior-park"), load_generator(mapping / "g").at, decoder
    )

    def by_hand(seen: np.ndarray) -> np.ndarray:
        skills = [policy.act(one) for one in seen[:: decoder.execute]]
        return np.float32(np.concatenate(skills)[: len(seen)])

    rows = read_external(puck(project), "pull").select([1])
    expected = by_hand(rows.observations.numpy())
    np.testing.assert_array_equal(np.float32(found["actions"]), expected)
    shown = tmp_path / "shown.rrd"
    told = lfr(project, "view", "data/external/puck-pull", "--episode", "1", "--policy", str(out),
               "--save", str(shown))  # fmt: skip
    assert told.returncode == 0, told.stderr
    beside = rrd.rows(shown, "/action/action/policy", "Scalars:scalars")
    np.testing.assert_array_equal(np.float32(list(beside)), expected)
    for episode in found["episodes"]:
        seen, actions = (np.float32(episode[of]) for of in ("seen", "actions"))
        assert len(seen) == len(actions) + 1 > 2 * decoder.execute
        np.testing.assert_array_equal(actions, by_hand(seen[:-1]))


def lfr(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["lfr", *arguments], cwd=folder, env=tiny_project.ENVIRONMENT, capture_output=True,
        text=True, check=False,
    )  # fmt: skip


def test_the_chain_is_measured_in_the_targets_environment(project: Path) -> None:
    """Each start's outcome is that of a loop by hand over the plain environment."""
    chain = read_json(project / f"results/mapping/{NAME}.json")["zero_shot"]
    assert list(chain) == ["identity", "no_generator", "linear", "mapped"]
    skills, mapping = project / "models/external-skills", project / "models/mapping" / NAME
    decoder = load_vae(skills / TARGET / "vae")
    policy = SkillPolicy(
        load_prior(skills / SOURCE / "prior-park"), load_generator(mapping / "g").at, decoder
    )
    plane, outcomes = gymnasium.make("lfr-test/Plane-v0"), ""
    for index in range(4):
        seen, _ = plane.reset(seed=episode_seed("held-out", index))
        success = ended = False
        while not ended:
            for action in policy.act(seen["agent_pos"]):
                seen, _, terminated, truncated, info = plane.step(np.float32(action))
                success, ended = success or info["is_success"], terminated or truncated
                if ended:
                    break
        outcomes += "01"[success]
    assert chain["mapped"]["outcomes"] == outcomes
    judged = read_json(project / f"results/evaluate/{NAME}-lfr.json")
    assert judged["judge"] == "environment"
    assert judged["runs"][0]["zero_shot"]["outcomes"] == outcomes


def test_it_learns_in_the_targets_environment(project: Path) -> None:
    learned = read_json(project / f"results/transfer/{NAME}-lfr.json")
    (run,) = learned["runs"]
    assert run["env_steps"] >= 300
    assert run["updates"] > 0
    judged = read_json(project / f"results/evaluate/{NAME}-lfr.json")["runs"][0]
    assert judged["success"]["environment"]["episodes"] == 4
    actor, about = load_policy(project / f"models/transfer/{NAME}-lfr/seed-0")
    assert (about["robot"], about["task"]) == ("puck", "park")
    assert actor.act(np.zeros(4)).shape == (3, 4)


def test_what_it_has_learned_is_exported_and_viewed(project: Path, tmp_path: Path) -> None:
    learned, out = f"models/transfer/{NAME}-lfr/seed-0", tmp_path / "learned"
    told = lfr(project, "export", learned, str(out))
    assert "sees observation.state, 4 numbers" in told.stdout, told.stderr
    sizes = read_json(out / "config.json")["columns"]["observation"][0]
    assert (sizes["size"], sizes["places"]) == (4, [0, 1, 2, 3])
    curves, episode = tmp_path / "curves.rrd", tmp_path / "episode.rrd"
    told = lfr(project, "view", f"results/transfer/{NAME}-lfr.csv", "--save", str(curves))
    assert told.returncode == 0, told.stderr
    assert len(rrd.rows(curves, "/evaluation/success", "Scalars:scalars")) >= 2
    told = lfr(project, "view", f"models/learning/{NAME}-lfr", "--save", str(episode))
    assert told.returncode == 0, told.stderr
    shown = [store.application_id for store in RrdReader(episode).recordings()]
    assert any("puck" in title and "environment steps" in title for title in shown), shown
    told = lfr(project, "view", learned, "--save", str(episode))  # in the puck's own environment
    assert told.returncode == 0, told.stderr
    assert any("puck" in one.application_id for one in RrdReader(episode).recordings())


def test_an_exported_policy_is_recorded_as_it_acts(project: Path, tmp_path: Path) -> None:
    out, shown = tmp_path / "policy", tmp_path / "shown"
    assert lfr(project, "export", f"models/mapping/{NAME}", str(out)).returncode == 0
    told = lfr(project, "record", "puck", "park", "--policy", str(out), "--to", str(shown),
               "--logs", str(tmp_path / "logs"), "--episodes", "1", "--attempts", "12")  # fmt: skip
    if told.returncode == 0:  # it was trained for seconds, and may reach nothing
        assert LeRobotDataset("lfr/shown", root=shown).num_episodes == 1
    else:
        assert f"{out} succeeded in 0 of 12 attempts" in told.stderr


def test_cards_claim_no_simulation(project: Path) -> None:
    judged = "No arm has moved by it outside the environment that it was judged in."
    for stage, name, words in (
        ("skills", "crane", "No arm has moved by it anywhere."), ("skills", "puck", judged),
        ("mapping", NAME, judged), ("transfer", f"{NAME}-lfr", "the target's own environment"),
    ):  # fmt: skip
        place = "external-skills" if stage == "skills" else stage
        facts = read_models(project / "models" / place / name, project / "results")
        assert facts.folder == f"models/{place}/{name}"
        text = model_card(facts)
        assert "robosuite" not in text
        assert "license:" not in text
        assert "imulated" not in text
        assert f"dvc repro external-{stage}@{name}" in text
        assert words in text


def test_arms_that_observe_different_things_are_refused_before_training(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    changes = {
        "goal otherwise": (("names: [hand_pos.x, hand_pos.y, goal_pos.x, goal_pos.y]",
                            "names: [hand_pos.x, hand_pos.y, aim_pos.x, aim_pos.y]"),
                           "puck observes push otherwise than crane.*found aim_pos.x, "
                           "expected goal_pos.x"),
        "one more": (("dims: [x_mm, y_mm]\n          names: [hand_pos.x, hand_pos.y]",
                      "names: [hand_pos.y, hand_pos.x, number.reach]"),
                     "dimension 0, found hand_pos.x, expected"),
        "millimetres": (("names: [hand_pos.x, hand_pos.y]\n          unit: 1000",
                         "names: [hand_pos.x, hand_pos.y]"),
                        "puck and crane observe hand_pos.x in different units.*hand_pos.x of push, "
                        r"found -0\.\d+ to 0\.\d+, expected about -\d{3}"),
        "rate": (("puck:\n      fps: 10", "puck:\n      fps: 20"), "another fps.*found 20, expect"),
    }  # fmt: skip
    monkeypatch.chdir(project)
    for (old, new), message in changes.values():
        changed = tmp_path / "params.yaml"
        assert old in made_up.EXTERNAL
        changed.write_text(made_up.params(made_up.EXTERNAL.replace(old, new, 1)))
        with pytest.raises(LfrError, match=message):
            check_arms(scenario("plane", changed), external(changed).arms)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("common: [push, pull]", "common: [push, pool]", "unknown task of crane 'pool'; valid: pu"),
        (
            "arms: [crane, puck]",
            "arms: [crane, pluck]",
            "unknown robot 'pluck'; valid: panda, .*, crane, puck",
        ),
        ("arms: [crane, puck], ", "", "found 1 robots under 'new', expected two"),
        ("new: {puck: park}", "new: {}", "found no robot under 'new', expected one of crane, puck"),
        ("new: {puck: park}", "new: {crane: lift}", "unknown task of puck 'lift'"),
        ("    plane: {", "    s1: {", "s1 under 'scenarios' and under 'external'"),
    ],
)  # fmt: skip
def test_a_scenario_of_external_arms_that_cannot_be(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    path = tmp_path / "params.yaml"
    assert old in made_up.EXTERNAL
    path.write_text(made_up.params(made_up.EXTERNAL.replace(old, new)))
    with pytest.raises(LfrError, match=message):
        transfer(NAME, path)


def test_dvc_runs_them_and_nothing_else(project: Path, tmp_path: Path) -> None:
    """The stages of these arms ask for no demonstration of the simulated ones."""
    folder = tiny_project.make(tmp_path / "project", made_up.params())
    for name in ("data", "results", "models", "work"):
        if (project / name).exists():
            (folder / name).symlink_to(project / name)
    planned = tiny_project.run(folder, "dvc", "repro", "--dry", f"external-mapping@{NAME}").stdout
    for robot in ("crane", "puck"):
        assert f"pipeline.skills --robot {robot}" in planned
    assert f"pipeline.mapping --transfer {NAME}" in planned
    assert "pipeline.record" not in planned
    assert "pipeline.pack" not in planned
