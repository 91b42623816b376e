"""Which models stand behind each zero-shot policy, and that a retrained one is judged anew."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch

from lfr.artifacts import fingerprint
from lfr.errors import DataError
from lfr.evaluation.trials import Trial
from lfr.mapping.generator import Generator
from lfr.mapping.saved_generators import MappingSeen, save_generator
from lfr.scenarios import Role, Scenario, transfers_of
from lfr.skills.library import RoleModels, transfer_models
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import Seen, save_prior, save_vae
from lfr.skills.skill_policy import SkillPolicy
from lfr.skills.vae import SkillVAE
from lfr.tasks import task
from studies.ablations.other_task import OtherTaskPrior, asked_about, save_other_task
from studies.zero_shot import model_trials, variant_trials
from tests.skills.made_up import actions_of, save_models

SCENARIO = Scenario("s1", ("pick_place", "nut_assembly"), {"panda": "lift", "sawyer": "stack"})
TRANSFER = transfers_of(SCENARIO)[0]  # lift from sawyer to panda
SEEN = Seen("sawyer", ("lift",), {}, 0)
LIFT = task("lift").observation.names


def prior(of: str = "lift") -> SkillPrior:
    return SkillPrior(task(of).observation.names, 3, hidden=4, layers=1)


def generator(folder: Path) -> None:
    save_generator(folder, Generator(3, 4, 2), MappingSeen("t", "a", "b", ("a/", "b/"), (), {}, 0))


def skills(folder: Path) -> dict[Role, RoleModels]:
    return transfer_models(SCENARIO, TRANSFER, folder / "skills")


def retrain(folder: Path, role: Role) -> None:
    save_models(skills(folder)[role], SkillVAE(4, 7, 3, 4), {})


def repetition(folder: Path) -> Path:
    for role, models in skills(folder).items():
        priors = {} if role == "target" else {"lift": prior()}
        save_models(models, SkillVAE(4, 7, 3, 4), priors)
    for name in ("g", "linear"):
        generator(folder / "mapping" / name)
    return folder


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path, Path]:
    """Two repetitions and the first one's variants."""
    torch.manual_seed(0)
    variants = tmp_path / "variants"
    for name in ("no_cycle", "shuffled", "untrained", "constant", "between_seeds",
                 "only_pick_place", "only_nut_assembly"):  # fmt: skip
        generator(variants / name / "g")
    save_vae(variants / "shared_vae" / "vae", SkillVAE(4, 7, 3, 4), SEEN)
    save_prior(variants / "shared_vae" / "prior", prior(), SEEN)
    wrong = asked_about(prior("pick_place"), "can", LIFT, "cube")
    save_other_task(variants / "wrong_task" / "prior", wrong, SEEN)
    return repetition(tmp_path / "seed-0"), repetition(tmp_path / "seed-1"), variants


def every(folders: tuple[Path, Path, Path]) -> dict[str, Trial]:
    models, other, variants = folders
    skilled, mapping = skills(models), models / "mapping"
    own = model_trials(TRANSFER, skilled, mapping, 5)
    source = skills(other)["source"]
    return own | variant_trials(TRANSFER, skilled, mapping, source, variants, 5)


def test_every_policy_has_its_arm_and_acts(folders: tuple[Path, Path, Path]) -> None:
    trials = every(folders)
    assert set(trials) == {
        "own_arm", "identity", "recoded", "mapped", "oracle", "oracle_decoder", "no_generator",
        "shared_vae", "linear", "no_cycle", "shuffled", "untrained", "constant", "between_seeds",
        "wrong_task", "only_pick_place", "only_nut_assembly",
    }  # fmt: skip
    on_source = {name for name, trial in trials.items() if trial.robot == "sawyer"}
    assert on_source == {"own_arm", "between_seeds"}
    for trial in trials.values():
        assert (trial.task, trial.episodes) == ("lift", 5)
        policy = trial.policy.load(trial.robot)
        assert policy.act(torch.zeros(len(LIFT)).numpy()).shape == (4, 7)
    wrong = trials["wrong_task"].policy.load("panda")
    assert isinstance(wrong, SkillPolicy)
    assert isinstance(wrong.prior, OtherTaskPrior)
    # No two are the same policy on the same arm.
    assert len({fingerprint(trial) for trial in trials.values()}) == len(trials)


def test_a_retrained_model_is_judged_anew_and_no_other(folders: tuple[Path, Path, Path]) -> None:
    models, other, variants = folders
    before = {name: fingerprint(trial) for name, trial in every(folders).items()}
    assert before == {name: fingerprint(trial) for name, trial in every(folders).items()}

    def changed() -> set[str]:
        return {name for name, one in every(folders).items() if fingerprint(one) != before[name]}

    generator(variants / "no_cycle" / "g")
    assert changed() == {"no_cycle"}
    retrain(other, "source")
    assert changed() == {"no_cycle", "between_seeds"}
    retrain(models, "oracle")
    assert changed() == {"no_cycle", "between_seeds", "oracle", "oracle_decoder"}
    generator(models / "mapping" / "g")
    expected = {"no_cycle", "between_seeds", "oracle", "oracle_decoder", "mapped", "wrong_task"}
    assert changed() == expected


def test_a_missing_model_is_named(folders: tuple[Path, Path, Path], tmp_path: Path) -> None:
    with pytest.raises(DataError, match="nothing"):
        every((folders[0], folders[1], tmp_path / "nothing"))


def test_arms_whose_actions_differ_have_their_policies_too(tmp_path: Path) -> None:
    """Nothing is carried over as it is but by identity, and retargeting is there."""
    arms = "panda-joint_position", "ur5e-joint_position"
    scenario = Scenario("j", ("pick_place",), {arms[1]: "lift"}, arms)
    (transfer,) = transfers_of(scenario)
    models = transfer_models(scenario, transfer, tmp_path)
    for one in models.values():
        actions = actions_of(one.robot)
        assert actions is not None
        save_models(one, SkillVAE(4, len(actions.names), 3, 4), {"lift": prior()})
    for name in ("g", "linear"):
        generator(tmp_path / "mapping" / name)
    trials = model_trials(transfer, models, tmp_path / "mapping", 5)
    assert set(trials) == {
        "own_arm", "identity", "no_generator", "linear", "mapped", "retarget", "oracle",
    }  # fmt: skip
    assert all(trial.robot == arms[name != "own_arm"] for name, trial in trials.items())
