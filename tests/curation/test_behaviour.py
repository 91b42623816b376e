"""What a recording shows: each fault that is put into one episode is named there, and no other."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lfr.curation.checks.behaviour import check_behaviour
from lfr.curation.checks.behaviour.signals import stretches
from lfr.curation.checks.pictures import check_pictures
from lfr.curation.checks.values import check_values
from lfr.curation.contents import Contents
from lfr.curation.finding import Finding
from lfr.curation.verify import verify_dataset

from . import arm
from .arm import Edit, K, Recording, of_action, of_pictures, of_state


def stuck(values: np.ndarray) -> None:
    values[20:45] = values[20]


def one_stuck(values: np.ndarray) -> None:
    values[20:45, 1] = values[20, 1]


def assign(where, value) -> Callable[[np.ndarray], None]:
    def change(values: np.ndarray) -> None:
        values[where] = value

    return change


def add(where, value) -> Callable[[np.ndarray], None]:
    def change(values: np.ndarray) -> None:
        values[where] += value

    return change


def times(where, value) -> Callable[[np.ndarray], None]:
    def change(values: np.ndarray) -> None:
        values[where] *= value

    return change


def swapped(values: np.ndarray) -> None:
    values[:, [0, 1]] = values[:, [1, 0]]


def late(values: np.ndarray) -> None:
    values[10:] = values[:-10].copy()
    values[:10] = values[10] + np.random.default_rng(0).normal(0, 2e-4, (10, 4))


def trembling(values: np.ndarray) -> None:
    values += np.random.default_rng(0).normal(0, 0.05, values.shape).astype(np.float32)


def at_a_limit(values: np.ndarray) -> None:
    values[:, 0] = np.minimum(values[:, 0], np.quantile(values[:, 0], 0.4))


def in_degrees(of: Recording) -> None:
    for part in (of.states, of.actions):
        part[K][:, :3] *= np.float32(180 / np.pi)


def repeat(rows: Callable[[int], np.ndarray]) -> Edit:
    """An episode's rows in another order, or more often."""

    def change(of: Recording) -> None:
        for part in (of.states, of.actions, of.pictures):
            part[K] = part[K][rows(len(part[K]))]

    return change


def idle_end(of: Recording) -> None:
    noise = np.random.default_rng(0).normal(0, 2e-4, (120, 4)).astype(np.float32)
    for part in (of.states, of.actions):
        part[K] = np.concatenate([part[K], part[K][-1] + noise])


def joined(of: Recording) -> None:
    for part in (of.states, of.actions, of.pictures):
        part[K] = np.concatenate([part[K], part[K + 1]])
        del part[K + 1]


def twice(of: Recording) -> None:
    for part in (of.states, of.actions, of.pictures):
        part.append(part[K].copy())


def nearly_twice(of: Recording) -> None:
    twice(of)
    of.states[-1] = of.states[-1] + np.random.default_rng(0).normal(0, 1e-4, of.states[-1].shape)


def half_rate(of: Recording) -> None:
    for part in (of.states, of.actions):
        part[:] = [values[np.arange(len(values)) // 2 * 2] for values in part]


def copied(of: Recording) -> None:
    of.actions[:] = [state.copy() for state in of.states]


def state_in_degrees(of: Recording) -> None:
    of.states[:] = [state * np.float32(180 / np.pi) for state in of.states]


def all_late(of: Recording) -> None:
    for actions in of.actions:
        late(actions)


def wrapped(values: np.ndarray) -> None:
    values[40:, 2] += 2 * np.pi


FAULTS: dict[str, tuple[Edit, str, str]] = {
    "the state is stuck": (of_state(stuck), "stuck", r"observation\.state.*frames 20 to 44"),
    "a joint is stuck": (of_state(one_stuck), "stuck", r"elbow\.pos, frames 20 to 44.*1.2 s"),
    "an action is dead": (of_action(assign((slice(None), 2), 0.3)), "still", r"action: wrist\.pos"),
    "the gripper never moves": (
        lambda of: [
            of_state(assign((slice(None), 3), 0.0))(of),
            of_action(assign((slice(None), 3), 0.0))(of),
        ],
        "still",
        r"gripper\.pos.*changes in 94 %",
    ),
    "idle at its end": (idle_end, "idle", "at its end.*found 5.8 s"),
    "half the rate": (half_rate, "repeated-rows", "50 % of the rows.*15 more"),
    "a spike": (of_state(add((30, 2), 0.8)), "jump", r"a single row.*wrist\.pos, frames 30 to 31"),
    "a spike of the action": (of_action(add((30, 0), 5.0)), "jump", r"shoulder\.pos, frames 30"),
    "a jump": (of_state(add((slice(30, None), 0), 0.9)), "jump", r"shoulder\.pos, frames 30 to 30"),
    "a turn": (of_state(wrapped), "jump", r"wraps.*wrist\.pos, frames 40 to 40"),
    "two in one": (joined, "jump", "two episodes in one"),
    "trembling": (of_state(trembling), "noise", "times the median episode's"),
    "a trembling action": (of_action(trembling), "noise", "column action"),
    "another unit": (in_degrees, "unit", "5. times the median"),
    "the state in another unit": (state_in_degrees, "unit", "the state in degrees"),
    "another sign": (of_state(times((slice(None), 0), -1.0)), "tracking", "another sign"),
    "another order": (of_state(swapped), "tracking", r"shoulder\.pos, elbow\.pos"),
    "an offset": (of_action(add(slice(None), 0.15)), "tracking", "by the same all along"),
    "out of step": (of_action(late), "lag", r"found -0.40 s, expected \+0.10 s"),
    "actions after states": (all_late, "lag", "actions come after.*0.40 s"),
    "a copy of the state": (copied, "copied", "the action is the state"),
    "a bound of its own": (of_action(at_a_limit), "pinned", r"action: shoulder\.pos"),
    "one row": (repeat(lambda n: np.arange(1)), "length", "much shorter.*found 1 rows"),
    "slow": (repeat(lambda n: np.arange(n).repeat(5)), "length", "much longer or slower"),
    "twice": (twice, "duplicate", "episode 16.*found episode 7"),
    "nearly twice": (nearly_twice, "duplicate", "episode 16.*found episode 7"),
}


def black(pictures: np.ndarray) -> np.ndarray:
    return np.zeros_like(pictures)


def noisy(pictures: np.ndarray) -> np.ndarray:
    return np.random.default_rng(0).integers(0, 255, pictures.shape, dtype=np.uint8)


def blurred(pictures: np.ndarray) -> np.ndarray:
    soft = pictures.astype(np.float32)
    for axis in (1, 2):
        soft = sum(np.roll(soft, d, axis) for d in range(-6, 7)) / 13
    return np.asarray(soft).astype(np.uint8)


def frozen(pictures: np.ndarray) -> np.ndarray:
    rows = np.arange(len(pictures))
    return pictures[np.where((rows >= 12) & (rows < 50), 12, rows)]


def delayed(pictures: np.ndarray) -> np.ndarray:
    return pictures[np.maximum(np.arange(len(pictures)) - 10, 0)]


def of_another(of: Recording) -> None:
    rows = np.minimum(np.arange(len(of.pictures[K])), len(of.pictures[K + 2]) - 1)
    of.pictures[K] = of.pictures[K + 2][rows]


PICTURES: dict[str, tuple[Edit, str, str]] = {
    "black": (of_pictures(black), "blank-picture", "black"),
    "blank": (of_pictures(lambda p: np.full_like(p, 120)), "blank-picture", "blank"),
    "noise": (of_pictures(noisy), "noisy-picture", "more detail"),
    "blurred": (of_pictures(blurred), "blurred-picture", "less detail"),
    "upside down": (of_pictures(lambda p: p[:, ::-1, ::-1]), "view", "upside down"),
    "colours swapped": (of_pictures(lambda p: p[..., ::-1]), "view", "red and blue"),
    "frozen": (of_pictures(frozen), "frozen-picture", "stays where"),
    "of another episode": (of_another, "other-pictures", "found those of episode"),
    "late": (of_pictures(delayed), "shifted-pictures", r"found \+0.[45]0 s"),
}


def found(path: Path, *, pictures: bool = False) -> list[Finding]:
    contents = Contents.open(path)
    return list(check_pictures(contents) if pictures else check_behaviour(contents))


def test_nothing_is_said_of_a_sound_recording(tmp_path: Path) -> None:
    path = arm.write(tmp_path / "arm", arm.recording(), pictures=True)
    assert found(path) == []
    assert found(path, pictures=True) == []
    assert not verify_dataset(path, pictures=3).errors


def test_a_hand_that_opens_and_closes_often_is_no_noise(tmp_path: Path) -> None:
    of = arm.recording()
    wave = 0.5 + 0.4 * np.sin(np.arange(len(of.states[K]) + 2) / 2.5)
    of.states[K][:, 3], of.actions[K][:, 3] = wave[:-2], wave[2:]
    path = arm.write(tmp_path / "arm", of)
    assert "noise" not in {one.check for one in found(path)}


FALL = [1.0, 0.94, 0.7, -0.2, -0.6, -0.6, -0.6]


@pytest.mark.parametrize(
    ("heights", "spike"),
    [(FALL, False), ([-0.6], True), ([-0.6] * 4, True)],
    ids=["falls", "a row", "rows"],
)
def test_what_falls_is_no_spike(heights: list[float], spike: bool, tmp_path: Path) -> None:
    of = arm.recording()
    random = np.random.default_rng(1)
    for state in of.states:
        state[:, 3] = 1 - random.uniform(0, 5e-3, len(state))
    last = len(of.states[K]) - (0 if not spike else 5)
    of.states[K][last - len(heights) : last, 3] = heights
    contents = Contents.open(arm.write(tmp_path / "arm", of))
    assert ("spike" in {one.check for one in check_values(contents)}) == spike


def _named(findings: list[Finding], check: str, shown: str) -> None:
    lines = [str(finding) for finding in findings]
    assert any(
        one.check == check and one.severity == "warning" and re.search(shown, line)
        for one, line in zip(findings, lines, strict=True)
    ), "\n".join(lines) or "nothing was found"
    odd = {one.episode for one in findings if one.check not in ("repeated-rows",)}
    assert odd <= {K, 16, None} | ({K + 2} if check == "other-pictures" else set())


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_named_in_its_episode(name: str, tmp_path: Path) -> None:
    edit, check, shown = FAULTS[name]
    of = arm.recording()
    edit(of)
    _named(found(arm.write(tmp_path / "arm", of)), check, shown)


@pytest.mark.parametrize("name", PICTURES)
def test_a_fault_of_the_pictures_is_named_in_its_episode(name: str, tmp_path: Path) -> None:
    edit, check, shown = PICTURES[name]
    of = arm.recording()
    edit(of)
    path = arm.write(tmp_path / "arm", of, pictures=True)
    _named(found(path, pictures=True), check, shown)


def test_pictures_are_looked_at_only_if_asked_for(tmp_path: Path) -> None:
    of = arm.recording()
    of_pictures(black)(of)
    path = arm.write(tmp_path / "arm", of, pictures=True)
    assert {one.check for one in verify_dataset(path).findings} == {"missing-file"}  # statistics
    assert "blank-picture" in {one.check for one in verify_dataset(path, pictures=5).findings}


def test_damaged_packets_are_found_by_decoding(tmp_path: Path) -> None:
    path = arm.write(tmp_path / "arm", arm.recording(6), pictures=True)
    file = path / f"videos/{arm.CAMERA}/chunk-000/file-000.mp4"
    content = bytearray(file.read_bytes())
    at = len(content) // 2
    content[at : at + 2048] = np.random.default_rng(0).bytes(2048)
    file.write_bytes(bytes(content))
    assert "damaged-picture" in {one.check for one in found(path, pictures=True)}


@pytest.mark.parametrize(
    ("codec", "pixels", "told", "shown"),
    [
        ("libx264", "yuv420p", {"video.codec": "av1"}, "found h264, expected av1"),
        ("libsvtav1", "yuv420p", {"video.codec": "h264"}, "found av1, expected h264"),
        ("libx264", "yuv444p", {"video.pix_fmt": "yuv420p"}, "found yuv444p, expected yuv420p"),
        ("libx264", "yuv420p", {"video.codec": "libx264", "video.pix_fmt": "yuv420p"}, None),
        ("libsvtav1", "yuv420p", {"video.codec": "libsvtav1", "video.pix_fmt": "yuv420p"}, None),
        ("libsvtav1", "yuv420p10le", {"video.pix_fmt": "yuv420p"}, "found yuv420p10le"),
    ],
)
def test_the_format_is_told_by_the_files_header(
    codec: str, pixels: str, told: dict[str, str], shown: str | None, tmp_path: Path
) -> None:
    of = arm.recording(2)
    path = arm.write(tmp_path / "arm", of, pictures=True)
    video = path / f"videos/{arm.CAMERA}/chunk-000/file-000.mp4"
    arm.encode(video, np.concatenate(of.pictures), codec, pixels)
    contents = Contents.open(path)
    contents.info["features"][arm.CAMERA]["info"] = told
    from lfr.curation.checks.videos import check_videos

    lines = [str(one) for one in check_videos(contents) if one.check == "format"]
    assert len(lines) == (shown is not None)
    assert all(shown in line for line in lines if shown)


def test_stretches_are_where_a_mask_is_true() -> None:
    start, length = stretches(np.array([True, True, False, True, False, True]))
    assert (start.tolist(), length.tolist()) == ([0, 3, 5], [2, 1, 1])
    assert [part.tolist() for part in stretches(np.zeros(3, bool))] == [[], []]


def test_a_finding_says_its_frames() -> None:
    one = Finding("jump", "jumps", "warning", episode=2, row=130, frames=(10, 12))
    assert str(one).endswith("episode 2, frames 10 to 12")
    assert replace(one, frames=None).as_json()["frames"] is None
    assert one.as_json()["frames"] == [10, 12]
