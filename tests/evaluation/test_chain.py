"""Which links a chain has, and that no arm carries out what it cannot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lfr.embodiments import embodiment
from lfr.errors import DataError
from lfr.evaluation.chain import chain_trials
from lfr.evaluation.trials import Trial
from lfr.mapping.generator import Generator
from lfr.mapping.saved_generators import MappingSeen, save_generator
from lfr.scenarios import Scenario, transfers_of
from lfr.skills.library import transfer_models
from lfr.skills.prior import SkillPrior
from lfr.skills.skill_policy import SkillFiles, UntranslatedFiles
from lfr.skills.vae import SkillVAE
from lfr.tasks import TASKS
from tests.skills.made_up import actions_of, save_models

LIFT = TASKS["lift"].observation.names


def chain(source: str, target: str, folder: Path) -> dict[str, Trial]:
    """Of lift, from models that have learned nothing."""
    scenario = Scenario("s1", ("pick_place",), {target: "lift"}, (source, target))
    (transfer,) = transfers_of(scenario)
    skills, mapping = transfer_models(scenario, transfer, folder), folder / "mapping"
    for role, priors in (("source", {"lift": SkillPrior(LIFT, 3, 4, 1)}), ("target", {})):
        actions = actions_of(skills[role].robot)
        assert actions is not None
        save_models(skills[role], SkillVAE(4, len(actions.names), 3, 4), priors)
    spaces = skills["source"].name, skills["target"].name
    seen = MappingSeen(transfer.name, source, target, spaces, transfer.common, {}, 0)
    for name in ("g", "linear"):
        save_generator(mapping / name, Generator(3, 4, 2), seen)
    return chain_trials(transfer, skills, mapping, 10)


ALIKE = ("identity", "no_generator", "recoded", "linear", "mapped")
OTHER = ("identity", "no_generator", "recoded", "linear", "mapped", "retarget")


@pytest.mark.parametrize(
    ("source", "target", "links"),
    [
        ("sawyer", "panda", ALIKE),
        ("panda", "ur5e", ALIKE),
        ("panda", "panda-joint_position", OTHER),
        ("panda-joint_position", "sawyer-joint_position", OTHER),
        ("panda", "ur5e-joint_position", OTHER),
    ],
)
def test_a_chain_has_the_links_that_its_arms_allow(
    source: str, target: str, links: tuple[str, ...], tmp_path: Path
) -> None:
    trials = chain(source, target, tmp_path)
    assert tuple(trials) == links
    actions = actions_of(target)
    assert actions is not None
    for name, trial in trials.items():
        assert (trial.robot, trial.task, trial.episodes) == (target, "lift", 10)
        if name == "retarget" or (
            name == "recoded" and links == OTHER
        ):  # step by step, in a simulation (tests/mapping/test_retarget.py)
            continue
        acted = trial.policy.load(trial.robot).act(np.zeros(len(LIFT)))
        assert acted.shape == (4, len(actions.names))


@pytest.mark.parametrize(
    ("of", "on", "first"),
    [
        ("panda", "panda-joint_position", "found dx, expected dq.joint1"),
        ("sawyer-joint_position", "sawyer", "found dq.right_j0, expected dx"),
        ("panda-joint_position", "sawyer-joint_position", "found dq.joint1, expected dq.right_j0"),
    ],
)
def test_an_arm_is_not_given_what_it_cannot_carry_out(
    of: str, on: str, first: str, tmp_path: Path
) -> None:
    """Also where both actions have as many dimensions."""
    scenario = Scenario("s1", ("pick_place",), {on: "lift"}, (of, on))
    (transfer,) = transfers_of(scenario)
    source = transfer_models(scenario, transfer, tmp_path)["source"]
    save_models(source, SkillVAE(4, 8, 3, 4), {"lift": SkillPrior(LIFT, 3, 4, 1)})
    files = SkillFiles(str(source.prior("lift")), str(source.vae()))
    assert files.load(of).decoder.horizon == 4
    message = f"{on} cannot carry out the actions of {of}: .*dimension 0, {first}"
    with pytest.raises(DataError, match=message):
        files.load(on)
    mapped = chain("sawyer", of, tmp_path / "chain")["mapped"]
    with pytest.raises(DataError, match=message):
        mapped.policy.load(on)


@pytest.mark.parametrize(("of", "on"), [("ur5e", "panda"), ("panda", "ur5e"), ("panda", "sawyer")])
def test_other_joints_carry_out_the_same_numbers(of: str, on: str, tmp_path: Path) -> None:
    source, target = f"{of}-joint_position", f"{on}-joint_position"
    trial = chain(source, target, tmp_path)["identity"]
    assert isinstance(trial.policy, UntranslatedFiles)
    files = SkillFiles(trial.policy.prior, trial.policy.decoder)
    seen = np.linspace(-0.3, 0.3, len(LIFT))
    own, carried = (one.load(robot).act(seen) for one, robot in
                    ((files, source), (trial.policy, target)))  # fmt: skip
    joints = [len(embodiment(robot).robot.joints) for robot in (source, target)]
    both = min(joints)
    np.testing.assert_array_equal(carried[:, :both], own[:, :both])
    np.testing.assert_array_equal(carried[:, both:-1], np.zeros((4, joints[1] - both)))
    np.testing.assert_array_equal(carried[:, -1], own[:, -1])
