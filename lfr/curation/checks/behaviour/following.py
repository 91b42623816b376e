"""Whether a state follows the action of the same names, episode by episode."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lfr.curation.checks.behaviour.signals import Array, Pair, correlation, warning
from lfr.curation.contents import Contents
from lfr.curation.finding import Finding

CLOSE = 0.15  # of its spread: where half of the episodes are further off, actions are no targets
OFF = 6.0  # times the median episode's error
OFF_LEAST = 0.03  # of its spread
LONGEST_LAG = 0.75  # seconds
APART = 0.15  # seconds, that an episode's lag may differ
BETTER = 2.0  # times, that its own lag must explain it better
DEGREES = 180.0 / np.pi


def following(contents: Contents, pair: Pair) -> Iterator[Finding]:
    """Units, copies, lags and errors of a state against its action."""
    state, action = pair.state, pair.action
    there = state.there
    if (state.values == action.values).all():
        yield Finding("copied", "the action is the state of the same row", "warning", "data",
                      column=action.key)  # fmt: skip
        return
    if (unit := _unit(pair)) is not None:
        yield Finding("unit", f"{unit} in degrees and the other in radians?", "warning", "data",
                      column=f"{state.key}, {action.key}",
                      found=f"their spreads differ by {DEGREES:.0f} times")  # fmt: skip
        return
    spread = np.maximum(np.maximum(state.spread, action.spread), 1e-12)
    most = int(LONGEST_LAG * contents.fps)
    lags = np.arange(-most, most + 1)
    errors = np.stack([_errors(pair, int(lag)) for lag in lags]) / spread  # (L, E, D)
    moving = state.moving & action.moving
    if not moving.any() or len(there.start) < 2:
        return
    together = errors[..., moving].mean(axis=-1)  # (L, E)
    best = together.argmin(axis=0)  # (E,)
    usual = int(np.median(best))
    at_usual = errors[usual]  # (E, D)
    middle = np.median(at_usual, axis=0)
    if np.median(together[usual]) > CLOSE:
        return
    if lags[usual] < -1:
        yield Finding("lag", "actions come after the states that they lead to", "warning", "data",
                      column=action.key, found=f"{-lags[usual] / contents.fps:.2f} s")  # fmt: skip
    episodes = np.arange(len(there.start))
    late = (np.abs(lags[best] - lags[usual]) > max(APART * contents.fps, 1)) & (
        together[usual] > BETTER * together[best, episodes]
    )
    off = (at_usual > OFF * middle) & (at_usual > OFF_LEAST) & (state.spread > 0)
    for episode in np.flatnonzero(late | off.any(axis=1)):
        if late[episode]:
            yield warning(
                contents, there, int(episode), "lag", "action and state are out of step",
                column=action.key, found=f"{lags[best[episode]] / contents.fps:+.2f} s",
                expected=f"{lags[usual] / contents.fps:+.2f} s, as in most episodes",
            )  # fmt: skip
            continue
        chosen = off[episode]
        worst = int(np.where(chosen, at_usual[episode] / np.maximum(middle, 1e-12), 0).argmax())
        yield warning(
            contents, there, int(episode), "tracking", _why(pair, int(episode), chosen),
            column=state.named(chosen),
            found=f"off by {100 * at_usual[episode, worst]:.0f} % of its spread",
            expected=f"{100 * middle[worst]:.1f} %, the median episode's",
        )  # fmt: skip


def _errors(pair: Pair, lag: int) -> Array:
    """(E, D) mean distance of the states ``lag`` rows after each action; where an episode is
    shorter, infinite.
    """
    state, action, there = pair.state.values, pair.action.values, pair.state.there
    count = len(state)
    rows = np.arange(count)
    later = rows + lag
    begin, end = there.of_rows(there.start), there.of_rows(there.start + there.length)
    inside = (later >= begin) & (later < end)
    error = np.abs(state[np.clip(later, 0, count - 1)] - action)
    error[~inside] = 0.0
    sums = np.add.reduceat(error, there.start, axis=0, dtype=np.float64)
    counts = np.add.reduceat(inside.astype(np.int64), there.start)[:, None]
    return np.where(counts > 0, sums / np.maximum(counts, 1), np.inf)


def _unit(pair: Pair) -> str | None:
    """Which of the two seems to be in degrees."""
    moving = pair.state.moving & pair.action.moving
    if moving.sum() < 2:
        return None
    ratio = pair.state.spread[moving] / pair.action.spread[moving]
    for name, wanted in (("the state", DEGREES), ("the action", 1.0 / DEGREES)):
        if (np.abs(np.log(ratio / wanted)) < 0.25).mean() > 0.5:
            return name
    return None


def _why(pair: Pair, episode: int, chosen: Array) -> str:
    """What explains that these dimensions do not follow."""
    there = pair.state.there
    rows = slice(there.start[episode], there.start[episode] + there.length[episode])
    state, action = pair.state.values[rows], pair.action.values[rows]
    dimensions = np.flatnonzero(chosen)
    for i in dimensions:
        if correlation(state[:, i], action[:, i]) < -0.5:
            return "goes against its action: another sign?"
        others = [correlation(state[:, i], action[:, j]) for j in dimensions if j != i]
        if others and max(others) > 0.95 > correlation(state[:, i], action[:, i]) + 0.1:
            return "follows another dimension's action: another order?"
    error = (state - action)[:, dimensions]
    if (np.abs(error.mean(axis=0)) > 3 * error.std(axis=0)).all():
        return "is beside its action by the same all along"
    return "does not follow its action"
