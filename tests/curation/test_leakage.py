"""What a training set and a test set share is found, whatever was done to it, and nothing else."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from lfr import cli
from lfr.curation import edit
from lfr.curation.diff.comparison import Comparison, compare_leakage
from lfr.seeds import FIRST

from . import arm
from .broken import EPISODES, VIDEO, column, info, put, removed, table

Change = Callable[[np.ndarray, np.random.Generator], np.ndarray]


def shared(found: Comparison) -> dict[str, list[tuple[int | None, int | None]]]:
    """The pairs of episodes, by kind."""
    kinds: dict[str, list[tuple[int | None, int | None]]] = {}
    for one in found.differences:
        kinds.setdefault(one.kind, []).extend(one.episodes)
    return kinds


@pytest.fixture
def train(tmp_path: Path) -> Path:
    return arm.write(tmp_path / "train", arm.recording(12, seed=1, drawn=False))


def with_episode(path: Path, k: int, change: Change) -> Path:
    """A test set of other episodes, whose second is the `k`-th of `train`, changed."""
    recorded, own = arm.recording(12, seed=1, drawn=False), arm.recording(5, seed=2, drawn=False)
    random = np.random.default_rng(0)
    own.states[1] = change(recorded.states[k], random).astype(np.float32)
    own.actions[1] = change(recorded.actions[k], random).astype(np.float32)
    return arm.write(path, own)


def test_sets_of_other_episodes_share_nothing(train: Path, tmp_path: Path) -> None:
    other = arm.write(tmp_path / "test", arm.recording(12, seed=2, drawn=False))
    found = compare_leakage(train, other)
    assert found.differences == ()
    assert str(found).endswith("12 and 12 episodes: nothing is shared")
    assert cli.main(["diff", str(train), str(other), "--leakage"]) == 0


def noisy(values: np.ndarray, random: np.random.Generator) -> np.ndarray:
    return values + random.normal(0, 0.002, values.shape) * np.ptp(values, axis=0)


def wild(values: np.ndarray) -> np.ndarray:
    """Rows far from these, and from each other farther still."""
    return values[:10] + 2 + 9 * (np.arange(10) % 2 == 0)[:, None]


@pytest.mark.parametrize(
    ("change", "kind", "rows"),
    [
        (lambda x, r: np.concatenate([wild(x), noisy(x, r), wild(x)]), "nearly-identical", 0),
        (lambda x, _: x, "identical", 0),
        (lambda x, _: x[10:-20], "shared-rows", -30),
        (lambda x, _: x[::2], "shared-rows", None),
        (lambda x, _: np.concatenate([x[:40], x[40:] + 0.5]), "shared-rows", None),
        (lambda x, _: np.concatenate([x[20:], x[-1:] + 0.3]), "shared-rows", -20),
        (noisy, "nearly-identical", 0),
        (lambda x, r: noisy(x, r)[15:], "nearly-identical", -15),
        (lambda x, r: noisy(x, r)[:-15], "nearly-identical", -15),
        (lambda x, r: np.concatenate([x[:1] - 0.5, noisy(x, r), x[-9:] + 0.4]),
         "nearly-identical", 0),
        (lambda x, r: np.concatenate([noisy(x, r)[20:], x[-20:] + 0.4]), "nearly-identical", -20),
    ],
)  # fmt: skip
def test_an_episode_is_found_whatever_was_done_to_it(
    train: Path, tmp_path: Path, change: Change, kind: str, rows: int | None
) -> None:
    for k in (0, 7):
        other = with_episode(tmp_path / f"test{k}", k, change)
        found = compare_leakage(train, other)
        assert shared(found) == {kind: [(k, 1)]}
        length = len(arm.recording(12, seed=1, drawn=False).states[k])
        assert rows is None or found.differences[0].rows == length + rows
        turned = compare_leakage(other, train)  # which of the two is the longer one is no matter
        assert shared(turned) == {kind: [(1, k)]}


def test_parts_of_a_dataset_share_no_rows_but_what_was_put_in_both(
    sound: Path, tmp_path: Path
) -> None:
    edit.split_episodes(sound, {"a": [0, 1, 2], "b": [3, 4]}, tmp_path / "parts")
    a, b = tmp_path / "parts/a", tmp_path / "parts/b"
    assert compare_leakage(a, b).differences == ()
    found = compare_leakage(sound, b)
    assert shared(found) == {"identical": [(3, 0), (4, 1)]}
    assert cli.main(["diff", str(sound), str(b), "--leakage"]) == 1


def test_the_same_pictures_beside_other_rows(tmp_path: Path) -> None:
    recorded = arm.recording(4)
    a = arm.write(tmp_path / "a", recorded, pictures=True)
    for values in (*recorded.states, *recorded.actions):
        values[:] = values[::-1] * 2 - 1
    b = arm.write(tmp_path / "b", recorded, pictures=True)
    table(EPISODES, lambda t: t.slice(0, 4))(b)
    assert shared(compare_leakage(a, b)) == {"same-pictures": [(i, i) for i in range(4)]}
    found = compare_leakage(a, b, pictures=False)
    assert (found.differences, found.not_compared) == ((), ("pictures",))
    removed(f"videos/{arm.CAMERA}/chunk-000/file-000.mp4")(b)
    found = compare_leakage(a, b)
    assert found.differences == ()
    assert "not there" in found.not_compared[0]


def test_the_same_states_beside_other_actions(train: Path, tmp_path: Path) -> None:
    own, recorded = arm.recording(5, seed=2, drawn=False), arm.recording(12, seed=1, drawn=False)
    own.states[2], own.actions[2] = recorded.states[6], recorded.actions[6] * 2 + 1
    other = arm.write(tmp_path / "test", own)
    found = compare_leakage(train, other)
    assert shared(found) == {"shared-column": [(6, 2)]}
    assert found.differences[0].column == arm.STATE


def test_the_same_start(train: Path, tmp_path: Path) -> None:
    own, recorded = arm.recording(5, seed=2, drawn=False), arm.recording(12, seed=1, drawn=False)
    own.states[3][0] = recorded.states[4][0]
    other = arm.write(tmp_path / "test", own)
    assert shared(compare_leakage(train, other)) == {"same-start": [(4, 3)]}


def test_an_arm_that_always_starts_at_home_leaks_nothing(tmp_path: Path) -> None:
    paths = []
    for seed in (1, 2):
        recorded = arm.recording(8, seed, drawn=False)
        for state in recorded.states:
            state[0] = 0.25
        paths.append(arm.write(tmp_path / str(seed), recorded))
    found = compare_leakage(*paths)
    assert found.differences == ()
    assert found.not_compared == ("starts (most episodes have the same)",)


def with_seeds(path: Path, seeds: list[int | None], robot: str = "arm", task: str = "x") -> Path:
    columns = {"seed": pa.array(seeds, pa.int64()), "robot": pa.array([robot] * len(seeds)),
               "task_name": pa.array([task] * len(seeds))}  # fmt: skip

    def added(before: pa.Table) -> pa.Table:
        for name, values in columns.items():
            before = before.append_column(name, values)
        return before

    table(EPISODES, added)(path)
    return path


def test_seeds(train: Path, tmp_path: Path) -> None:
    with_seeds(train, [*range(10), FIRST["held-out"], FIRST["learning"] + 3])
    plain = arm.write(tmp_path / "plain", arm.recording(4, seed=2, drawn=False))
    leaked = {"leaked-seed": [(10, None), (11, None)]}
    assert shared(compare_leakage(train, plain)) == leaked
    seeds: list[int | None] = [FIRST["held-out"], 50, 3, None]
    other = with_seeds(shutil.copytree(plain, tmp_path / "other"), seeds)
    assert shared(compare_leakage(train, other)) == {"same-seed": [(10, 0), (3, 2)], **leaked}
    # the same number is another start for another robot or task
    another = with_seeds(shutil.copytree(plain, tmp_path / "another"), seeds, task="y")
    assert shared(compare_leakage(train, another)) == leaked
    assert shared(compare_leakage(another, another))["identical"] == [(i, i) for i in range(4)]


def test_what_cannot_be_told_is_said(train: Path, sound: Path, tmp_path: Path) -> None:
    """Other columns of other sizes and names; nothing is an error, and nothing shared."""
    found = compare_leakage(train, sound)
    assert found.differences == ()
    assert any("other shapes" in line for line in found.not_compared)
    empty = shutil.copytree(sound, tmp_path / "empty")
    for file in (EPISODES, EPISODES.replace("meta/episodes", "data")):
        table(file, lambda t: t.slice(0, 0))(empty)
    for pair in ((empty, sound), (sound, empty), (empty, empty)):
        assert compare_leakage(*pair).differences == ()


def test_a_missing_number_hides_no_copy(train: Path, tmp_path: Path) -> None:
    other = with_episode(tmp_path / "test", 3, noisy)
    column(EPISODES.replace("meta/episodes", "data"), arm.ACTION,
           lambda v: v[90].__setitem__(0, float("nan")))(other)  # fmt: skip
    assert shared(compare_leakage(train, other)) == {"nearly-identical": [(3, 1)]}


def test_what_is_printed(sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    a, b = (shutil.copytree(sound, tmp_path / name) for name in "ab")
    info(robot_type="another")(b)
    removed(VIDEO)(b)
    put(EPISODES, "seed", 2, 2_000_000)(a)
    assert cli.main(["diff", str(a), str(b), "--leakage"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "identical: the same episode: episodes 0-4, 55 rows"
    assert lines[1].startswith("leaked-seed: a seed of held-out episodes in A, expected a demo")
    assert lines[1].endswith("episode 2, column seed, A 2000000, B nothing")
    assert "5 and 5 episodes: 5 identical, 1 leaked-seed; not compared: observ" in lines[2]
    assert cli.main(["diff", str(a), str(b), "--leakage", "--json"]) == 1
    content = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert content["leakage"]
    assert content["counts"] == {"identical": 5, "leaked-seed": 1}
