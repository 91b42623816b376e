"""The stages skills and mapping on two external arms, without a simulator, and what they give."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from lfr.artifacts import read_json
from lfr.errors import LfrError
from lfr.external import external
from lfr.hub.model_card import model_card
from lfr.hub.model_facts import read_models
from lfr.mapping.saved_generators import load_generator, load_mapping_seen
from lfr.scenarios import scenario, transfer
from lfr.skills.compatible import check_arms
from lfr.skills.saved_models import load_prior, load_seen, load_vae
from lfr.skills.skill_policy import SkillPolicy

from .. import tiny_project
from . import made_up

NAME = "plane-puck-park"
SOURCE, TARGET = "crane/park+pull+push", "puck/pull+push"
SIZES = """
skills:
  vae: {horizon: 5, execute: 3, latent_dim: 6, hidden: 32, steps: 800, batch: 64}
  prior: {hidden: 64, layers: 3, steps: 800, batch: 64}
  held_out: 0.25
mapping:
  {hidden: 64, steps: 1500, batch: 64, posterior_share: 0.25, condition: state, hand: {weight: 9}}
"""


def params(text: str = made_up.EXTERNAL) -> str:
    """The tiny parameters with these arms and networks that can learn something."""
    tiny = tiny_project.ROOT.joinpath("tests/tiny_params.yaml").read_text()
    kept, skip = [], False
    for line in tiny.splitlines(keepends=True):
        if not line.startswith((" ", "#")):
            skip = line.split(":")[0] in ("external", "skills", "mapping")
        if not skip:
            kept.append(line)
    return "".join(kept) + SIZES + text


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder after both stages, each a process that cannot import a simulator."""
    folder = tmp_path_factory.mktemp("theirs")
    made_up.write_both(folder / "data/external", episodes=12)
    (folder / "params.yaml").write_text(params())
    for stage, key in (("skills", "crane"), ("skills", "puck"), ("mapping", NAME)):
        option = "robot" if stage == "skills" else "transfer"
        code = (
            "import sys; sys.modules.update(mujoco=None, robosuite=None, numba=None)\n"
            f"from lfr.program import run_stage; from pipeline.{stage} import main\n"
            f"sys.argv[1:] = ['--{option}', '{key}']; sys.exit(run_stage(main))"
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


def test_cards_claim_no_simulation(project: Path) -> None:
    for stage, name, words in (("skills", "crane", "vae"), ("mapping", NAME, "generator")):
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
        "rate": (("puck:\n      fps: 10", "puck:\n      fps: 20"), "another fps.*found 20, expect"),
    }  # fmt: skip
    monkeypatch.chdir(project)
    for (old, new), message in changes.values():
        changed = tmp_path / "params.yaml"
        assert old in made_up.EXTERNAL
        changed.write_text(params(made_up.EXTERNAL.replace(old, new, 1)))
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
    path.write_text(params(made_up.EXTERNAL.replace(old, new)))
    with pytest.raises(LfrError, match=message):
        transfer(NAME, path)


def test_dvc_runs_them_and_nothing_else(project: Path, tmp_path: Path) -> None:
    """The stages of these arms ask for no demonstration of the simulated ones."""
    folder = tiny_project.make(tmp_path / "project", params())
    for name in ("data", "results", "models", "work"):
        if (project / name).exists():
            (folder / name).symlink_to(project / name)
    planned = tiny_project.run(folder, "dvc", "repro", "--dry", f"external-mapping@{NAME}").stdout
    for robot in ("crane", "puck"):
        assert f"pipeline.skills --robot {robot}" in planned
    assert f"pipeline.mapping --transfer {NAME}" in planned
    assert "pipeline.record" not in planned
    assert "pipeline.pack" not in planned
