"""What videos show, decoded: frozen, black, noisy, blurred, turned, of another episode or time.

Nothing of it is wrong by a rule but a frame that cannot be decoded: an episode's pictures are
compared with the other episodes' of the same camera, and with the robot's motion.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from lfr.curation.checks.behaviour.signals import (
    Signal,
    correlation,
    signals,
    stretches,
    warning,
)
from lfr.curation.checks.decoded import COARSE, COMPARED, Picture, Seen, decode
from lfr.curation.contents import Contents, Runs, runs
from lfr.curation.finding import Finding
from lfr.data.episode import STATE

DARK, FLAT = 0.03, 0.01  # of white: mean and spread of a picture that shows nothing
LONG = 1.0  # seconds that something must last
FROZEN, SURELY = 0.1, 2.5  # times the change that is usual while the robot moves, and times that
FROZEN_LONG = 2.0  # times `LONG`, where the pictures do not catch up after it
NEAREST, KNOWN = 7, 5_000  # pictures with the robot nearly there, among so many of all
FAR, ASKED = 2.0, 200  # times as far as usual these are where no other episode was; of so many rows
SHARPER, BLURRED = 3.0, 0.4  # times the finest detail of the median episode
STEADY = 0.8  # correlation of episodes' mean pictures, of a camera that stands still
OTHER_VIEW = 0.5  # the same of an episode from elsewhere
COLOURED = 0.4  # correlation of where their red is more than their blue
TURNED = 0.1  # better correlation of the turned picture
SAME = 0.1  # times the difference that nearest episodes have
LAG, LONGEST_LAG = 0.25, 1.0  # seconds that pictures may be beside the rows, and that are tried
MOST_PRODUCTS = 16  # dimensions of a state, of which all products explain a picture
MOMENTS = 6
BETTER = (2.0, 1.35)  # times, that they then must be better explained: by moments, or by pixels

TURNS = {
    "upside down": lambda picture: picture[::-1, ::-1],
    "mirrored": lambda picture: picture[:, ::-1],
    "flipped": lambda picture: picture[::-1],
}


def check_pictures(contents: Contents, stride: int = 2) -> Iterator[Finding]:
    """Every camera's pictures.

    Args:
        stride: every how many frames one is looked at.
    """
    there = runs(contents)
    state = next((one for one in signals(contents) if one.key == STATE), None)
    for key in contents.pictures():
        seen: dict[int, Seen] = {}
        yield from decode(contents, key, there, stride, seen)
        if seen:
            yield from _judge(contents, key, there, state, seen, stride)


def _judge(
    contents: Contents, key: str, there: Runs, state: Signal | None, seen: dict[int, Seen],
    stride: int,
) -> Iterator[Finding]:  # fmt: skip
    least = max(int(LONG * contents.fps / stride), 2)
    checks = (
        partial(_nothing, least=least), _sharpness, _views,
        _copies, partial(_frozen, state=state, least=least),
        partial(_shifted, state=state, stride=stride),
    )  # fmt: skip
    for check in checks:  # of an episode that is odd already nothing more is asked
        for finding in list(check(contents, key, there, seen)):
            seen.pop(_place(there, finding), None)
            yield finding


def _nothing(
    contents: Contents, key: str, there: Runs, seen: dict[int, Seen], least: int
) -> Iterator[Finding]:
    """Pictures of one colour, for a second or more."""
    for episode, one in seen.items():
        mean, spread = np.array(one.mean), np.array(one.spread)
        for mask, what in (
            ((mean < DARK) & (spread < DARK), "black"), ((spread < FLAT) & (mean >= DARK), "blank"),
        ):  # fmt: skip
            start, length = stretches(mask)
            for first, count in zip(start, length, strict=True):
                if count >= min(least, len(mask)):
                    yield warning(
                        contents, there, episode, "blank-picture", f"pictures that are {what}",
                        column=key, first=one.rows[first], last=one.rows[first + count - 1],
                        found=f"{100 * mean[first : first + count].mean():.0f} % of white",
                    )  # fmt: skip


def _sharpness(
    contents: Contents, key: str, there: Runs, seen: dict[int, Seen]
) -> Iterator[Finding]:
    """Episodes with much more or much less of the finest detail."""
    detail = {episode: float(np.median(one.detail)) for episode, one in seen.items()}
    usual = float(np.median(list(detail.values()))) if len(detail) > 2 else 0.0
    for episode, found in detail.items():
        if not usual or BLURRED * usual <= found <= SHARPER * usual:
            continue
        check, what = "noisy-picture", "more detail than in other episodes: noise?"
        if found < usual:
            check, what = "blurred-picture", "less detail than in other episodes: blurred?"
        yield warning(
            contents, there, episode, check, f"much {what}", column=key,
            found=f"{found / usual:.2g} times the median episode's",
        )  # fmt: skip


def _views(contents: Contents, key: str, there: Runs, seen: dict[int, Seen]) -> Iterator[Finding]:
    """Episodes whose mean picture is not the camera's: turned, other colours, another view."""
    if len(seen) < 3:
        return
    usual = np.median(np.stack([one.picture for one in seen.values()]), axis=0)
    alike = {e: correlation(_gray(one.picture), _gray(usual)) for e, one in seen.items()}
    colour = {e: correlation(_redness(one.picture), _redness(usual)) for e, one in seen.items()}
    if np.median(list(alike.values())) < STEADY:
        return  # a camera that moves
    usual_colour = float(np.median(list(colour.values())))
    for episode, one in seen.items():
        turned = {n: correlation(_gray(t(one.picture)), _gray(usual)) for n, t in TURNS.items()}
        name = max(turned, key=lambda which: turned[which])
        if turned[name] > alike[episode] + TURNED:
            what = f"the picture is {name}"
        elif usual_colour > COLOURED and colour[episode] < -0.5 * usual_colour:
            what = "red and blue are swapped: another order of colour channels"
        elif alike[episode] < OTHER_VIEW:
            what = "another view than the other episodes'"
        else:
            continue
        yield warning(
            contents, there, episode, "view", what, column=key,
            found=f"correlation {alike[episode]:.2f} with the camera's mean picture",
            expected=f"{np.median(list(alike.values())):.2f}",
        )  # fmt: skip


def _frozen(
    contents: Contents, key: str, there: Runs, seen: dict[int, Seen], state: Signal | None,
    least: int,
) -> Iterator[Finding]:  # fmt: skip
    """Pictures that stay where those of other episodes, with the robot there, change."""
    if state is None or not state.moving.any() or len(seen) < 3:
        return
    places = state.values[:, state.moving] / state.spread[state.moving]
    speed = (state.steps[:, state.moving] / state.spread[state.moving]).max(axis=1)
    moving = speed > 0.2 * np.median(speed)
    rows = np.concatenate([one.rows[1:] for one in seen.values()])
    change = np.concatenate([one.change[1:] for one in seen.values()])
    rows, change = rows[moving[rows]], change[moving[rows]]
    if not len(rows) or not np.median(change):
        return
    usual = float(np.median(change))
    threshold = FROZEN * usual
    some = np.random.default_rng(0).permutation(len(rows))[:KNOWN]
    rows, change = rows[some], change[some]
    known = FAR * _reach(places, rows, there)
    for episode, one in seen.items():
        own = np.array(one.rows)
        still = np.array(one.change) < threshold
        still[0] = False
        others = (rows < own[0]) | (rows > own[-1])
        for first, count in zip(*stretches(still), strict=True):
            of = own[first : first + count][moving[own[first : first + count]]]
            if len(of) < least or others.sum() < NEAREST:
                continue
            apart = np.abs(places[of][:, None] - places[rows[others]]).mean(axis=-1)
            near = np.argpartition(apart, NEAREST - 1, axis=1)[:, :NEAREST]
            reach = np.take_along_axis(apart, near, axis=1).max(axis=1)
            # A robot that is out of sight comes into it little by little; a camera catches up.
            caught_up = first + count < len(one.change) and one.change[first + count] > usual
            near = change[others][near]
            there_change = np.median(near, axis=1) if caught_up else near.min(axis=1)
            expected = (there_change > SURELY * threshold) & (reach < known)
            if expected.sum() >= least * (1.0 if caught_up else FROZEN_LONG):
                begin, end = of[expected][[0, -1]]
                yield warning(
                    contents, there, episode, "frozen-picture",
                    "stays where other episodes' pictures change", column=key, first=begin,
                    last=end, found=f"{(end - begin + 1) / contents.fps:.1f} s",
                )  # fmt: skip
                break


def _reach(places: NDArray, rows: NDArray[np.int64], there: Runs) -> float:
    """How far the NEAREST rows of other episodes usually are from one of some rows."""
    episodes = np.searchsorted(there.start, rows, side="right")
    asked = slice(0, ASKED)  # they are in no order
    apart = np.abs(places[rows[asked]][:, None] - places[rows]).mean(axis=-1)
    apart[episodes[asked][:, None] == episodes] = np.inf
    found = np.partition(apart, min(NEAREST, len(rows)) - 1, axis=1)[:, :NEAREST].max(axis=1)
    return float(np.median(found))


def _copies(contents: Contents, key: str, there: Runs, seen: dict[int, Seen]) -> Iterator[Finding]:
    """Episodes that show another one's pictures."""
    long = {episode: one for episode, one in seen.items() if len(one.first) == COMPARED}
    if len(long) < 4:
        return
    episodes = list(long)
    pictures = np.stack([np.stack(one.first).ravel() for one in long.values()])
    squares = (pictures**2).sum(axis=1)
    apart = np.sqrt(np.maximum(squares[:, None] + squares - 2 * pictures @ pictures.T, 0))
    np.fill_diagonal(apart, np.inf)
    nearest = apart.min(axis=1)
    usual = float(np.median(nearest))
    for place in np.flatnonzero(nearest < SAME * usual):
        other = int(apart[place].argmin())
        yield warning(
            contents, there, episodes[place], "other-pictures", "a video that is another episode's",
            column=key, found=f"those of episode {int(there.episode[episodes[other]])}",
        )  # fmt: skip


def _shifted(
    contents: Contents, key: str, there: Runs, seen: dict[int, Seen], state: Signal | None,
    stride: int,
) -> Iterator[Finding]:  # fmt: skip
    """Pictures that show where the robot was, or will be, by what they show in most episodes.

    What pictures show, and where how much is going on in them, is explained by the robot's state,
    by least squares over all episodes; of late ones, by the state of some rows before.
    """
    if state is None or not state.moving.any() or len(seen) < 5:
        return
    rows = np.concatenate([one.rows for one in seen.values()])
    shown = np.concatenate([one.coarse for one in seen.values()])
    apart = shown - np.median(shown, axis=0)
    explained = np.concatenate([_moments(np.abs(apart)), apart], axis=1)
    features = _features(state)
    some = np.random.default_rng(0).permutation(len(rows))[: 4 * KNOWN]
    x = features[rows[some]]
    weights = np.linalg.solve(x.T @ x + 1e-3 * len(x) * np.eye(x.shape[1]), x.T @ explained[some])
    expected = features @ weights
    ends = np.cumsum([len(one.rows) for one in seen.values()])
    most = max(int(LONGEST_LAG * contents.fps / stride), 1)
    lags = np.arange(-most, most + 1)
    errors = {}
    for (episode, one), end in zip(seen.items(), ends, strict=True):
        if len(one.rows) > 3 * most:
            found, wanted = explained[end - len(one.rows) : end], expected[one.rows]
            errors[episode] = np.stack([_apart(found, wanted, int(lag)) for lag in lags])
    if len(errors) < 5:
        return
    usual = np.median(np.stack(list(errors.values())), axis=0).argmin(axis=0)  # (2,)
    for episode, error in errors.items():
        for kind, better in enumerate(BETTER):
            best, middle = int(error[:, kind].argmin()), int(usual[kind])
            late = abs(best - middle) * stride >= LAG * contents.fps and 0 < best < len(lags) - 1
            if late and error[middle, kind] > better * error[best, kind]:
                yield warning(
                    contents, there, episode, "shifted-pictures",
                    "the pictures are out of step with the rows: shifted", column=key,
                    found=f"{(best - middle) * stride / contents.fps:+.2f} s",
                )  # fmt: skip
                break


def _moments(changed: NDArray) -> NDArray[np.float64]:
    """(F, MOMENTS): how much of pictures (F, COARSE^2) is unusual, and where; standardised."""
    y, x = np.mgrid[-1 : 1 : COARSE * 1j, -1 : 1 : COARSE * 1j].reshape(2, -1)
    moments = changed @ np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    return (moments - moments.mean(axis=0)) / np.maximum(moments.std(axis=0), 1e-9)


def _features(state: Signal) -> NDArray[np.float64]:
    """(N, K) of the state: 1, itself, and its products."""
    x = state.values[:, state.moving].astype(np.float64)
    x = (x - x.mean(axis=0)) / np.maximum(x.std(axis=0), 1e-12)
    count = x.shape[1]
    pairs = np.triu_indices(count) if count <= MOST_PRODUCTS else (np.arange(count),) * 2
    return np.concatenate([np.ones((len(x), 1)), x, x[:, pairs[0]] * x[:, pairs[1]]], axis=1)


def _apart(found: NDArray, wanted: NDArray, lag: int) -> NDArray[np.float64]:
    """(2,): how far pictures are from those expected ``lag`` before, by moments and by pixels."""
    if lag > 0:
        found, wanted = found[lag:], wanted[:-lag]
    elif lag < 0:
        found, wanted = found[:lag], wanted[-lag:]
    squares = np.square(found - wanted).mean(axis=0)
    return np.array([squares[:MOMENTS].mean(), squares[MOMENTS:].mean()])


def _gray(picture: Picture) -> Picture:
    return picture.mean(axis=-1)


def _redness(picture: Picture) -> Picture:
    return picture[..., 0] - picture[..., 2]


def _place(there: Runs, finding: Finding) -> int:
    """Which of the runs of rows a finding is about."""
    return int(np.searchsorted(there.start, finding.row or 0, side="right")) - 1
