"""A prior asked about another task: every dimension in its place."""

from __future__ import annotations

import copy
from itertools import permutations
from pathlib import Path

import pytest
import torch
from torch import Tensor

from lfr.errors import DataError
from lfr.skills.prior import SkillPrior
from lfr.skills.saved_models import Seen, load_prior
from lfr.spaces import ROBOT_STATE
from lfr.tasks import TASKS, task
from studies.spirl.any_task import ANY_TASK_NAMES, any_task_places
from studies.spirl.other_task import (
    OtherTaskPrior,
    asked_about,
    counterparts,
    load_other_task,
    save_other_task,
)

Z = 3
SEEN = Seen("panda", ("lift",), {}, 0)
# By hand from lfr.tasks: new task -> what a prior of the first task finds there (group -> group).
CUBE_IN_CAN = {"cube_pos": "can_pos", "cube_up": "can_up", "eef_to_cube": "eef_to_can"}
NUT_IN_STACK = {
    "nut_pos": "cubeA_pos",
    "nut_up": "cubeA_up",
    "eef_to_nut": "eef_to_cubeA",
    "nut_yaw": "cubeA_yaw",
    "nut_to_peg": "cubeA_to_cubeB",
}
STACK_IN_CAN = {
    "cubeA_pos": "can_pos",
    "cubeA_up": "can_up",
    "eef_to_cubeA": "eef_to_can",
    "cubeA_to_cubeB": "can_to_bin",
}


def names(of: str) -> tuple[str, ...]:
    return task(of).observation.names


def found(inner: str, new: str) -> dict[str, str | None]:
    """Name of each of the inner layout's dimensions -> name of its counterpart."""
    there = names(new)
    columns = counterparts(
        names(inner), task(inner).manipulated, there, task(new).manipulated
    )  # fmt: skip
    assert len(columns) == len(names(inner))
    return {
        name: there[c] if c >= 0 else None for name, c in zip(names(inner), columns, strict=True)
    }


def prior(of: str) -> SkillPrior:
    torch.manual_seed(1)
    made = SkillPrior(names(of), Z, hidden=8, layers=2)
    made.normalizer.fit(observations(of, 50, 3) + 0.2, names(of))
    return made.eval()


def observations(of: str, count: int, seed: int) -> Tensor:
    return torch.randn(count, len(names(of)), generator=torch.Generator().manual_seed(seed))


def asked(inner: str, new: str) -> OtherTaskPrior:
    return asked_about(prior(inner), task(inner).manipulated, names(new), task(new).manipulated)


@pytest.mark.parametrize(
    ("inner", "new", "groups"),
    [
        ("lift", "pick_place", CUBE_IN_CAN),
        ("nut_assembly", "stack", NUT_IN_STACK),
        ("stack", "pick_place", STACK_IN_CAN),
    ],
)
def test_counterparts_by_hand(inner: str, new: str, groups: dict[str, str]) -> None:
    for name, other in found(inner, new).items():
        group, _, part = name.partition(".")
        if name in ROBOT_STATE.names:
            assert other == name
        elif group in groups:
            assert other == f"{groups[group]}.{part}"
        else:
            assert other is None, name


@pytest.mark.parametrize(("inner", "new"), list(permutations(TASKS, 2)))
def test_every_pair_of_tasks(inner: str, new: str) -> None:
    columns = found(inner, new)
    known = [other for other in columns.values() if other is not None]
    assert len(known) == len(set(known))  # nothing stands for two things
    assert all(columns[name] == name for name in ROBOT_STATE.names)
    theirs, ours = task(inner).manipulated, task(new).manipulated
    for form in ("{}_pos", "{}_up", "eef_to_{}"):  # all tasks have these
        for axis in "xyz":
            assert columns[f"{form.format(theirs)}.{axis}"] == f"{form.format(ours)}.{axis}"
    # Components stay what they are, and the way back is the same.
    back = found(new, inner)
    for name, other in columns.items():
        if other is not None:
            assert name.partition(".")[2] == other.partition(".")[2]
            assert back[other] == name


def test_it_says_what_the_inner_prior_says_of_the_same_scene() -> None:
    inner, other = prior("nut_assembly"), asked("nut_assembly", "stack")
    seen = observations("stack", 6, 5)
    by_hand = inner.normalizer.mean.expand(6, -1).clone()
    layout = task("nut_assembly").observation
    there = task("stack").observation
    by_hand[:, : ROBOT_STATE.size] = seen[:, : ROBOT_STATE.size]
    for nut, cube in NUT_IN_STACK.items():
        by_hand[:, layout.slice(nut)] = seen[:, there.slice(cube)]
    for answer, expected in zip(other(seen), inner(by_hand), strict=True):
        assert answer.shape == (6, Z)
        assert torch.equal(answer, expected)


def test_its_own_task_is_answered_as_before() -> None:
    seen = observations("lift", 6, 5)
    for answer, expected in zip(asked("lift", "lift")(seen), prior("lift")(seen), strict=True):
        assert torch.equal(answer, expected)


def test_gradients_reach_all_weights_and_a_copy_is_its_own() -> None:
    other = asked("lift", "pick_place")
    twin = copy.deepcopy(other)
    mu, log_sigma = other(observations("pick_place", 6, 5))
    (mu.square().sum() + log_sigma.square().sum()).backward()
    weights = list(other.parameters())
    assert weights
    assert all(w.grad is not None and float(w.grad.abs().sum()) > 0 for w in weights)
    with torch.no_grad():
        weights[0].add_(1.0)
    assert not torch.equal(next(twin.parameters()), weights[0])


def test_saved_and_loaded(tmp_path: Path) -> None:
    other = asked("lift", "pick_place")
    save_other_task(tmp_path / "prior", other, SEEN)
    loaded = load_other_task(tmp_path / "prior")
    seen = observations("pick_place", 4, 5)
    assert loaded.layout_names == names("pick_place")
    assert loaded.columns == other.columns
    for answer, expected in zip(loaded(seen), other(seen), strict=True):
        assert torch.equal(answer, expected)
    with pytest.raises(DataError, match="another kind of model"):
        load_prior(tmp_path / "prior")


@pytest.mark.parametrize("of", TASKS)
def test_what_every_task_has(of: str) -> None:
    places, object_ = any_task_places(task(of)), task(of).manipulated
    expected = (
        *ROBOT_STATE.names,
        *(
            f"{form.format(object_)}.{axis}"
            for form in ("{}_pos", "{}_up", "eef_to_{}")
            for axis in "xyz"
        ),
    )
    assert tuple(names(of)[place] for place in places) == expected
    assert len(ANY_TASK_NAMES) == len(expected)
