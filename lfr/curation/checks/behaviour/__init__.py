"""What a recording shows, judged by its own rest: warnings, for someone to look at.

Nothing here is wrong by a rule. An episode is compared with the dataset's other episodes, a
dimension with itself elsewhere, a state with the action of the same name. Thresholds are wide: they
were set so that no episode of this project's own datasets is named, whose demonstrators are pushed,
slip and start all over the place.
"""

from __future__ import annotations

from collections.abc import Iterator

from lfr.curation.checks.behaviour.episodes import lengths, pinned, scales, twice
from lfr.curation.checks.behaviour.following import following
from lfr.curation.checks.behaviour.jumps import jumps, noise
from lfr.curation.checks.behaviour.signals import Pair, Signal, paired, signals
from lfr.curation.checks.behaviour.stillness import stillness
from lfr.curation.contents import Contents, runs
from lfr.curation.finding import Finding
from lfr.data.episode import ACTION

ENVIRONMENT = "observation.environment_state"  # objects, which fall and are knocked about


def check_behaviour(contents: Contents) -> Iterator[Finding]:
    """All of these checks, over what was observed and done."""
    yield from lengths(contents, runs(contents))
    found = signals(contents)
    if not found:
        return
    pair = paired(found)
    yield from twice(contents, found)
    yield from stillness(contents, found, pair)
    robot = [signal for signal in found if signal.key != ENVIRONMENT]
    units = [finding for signal in robot for finding in scales(contents, signal)]
    yield from units
    other_units = {finding.episode for finding in units}
    for finding in _motion(contents, robot, pair):
        if finding.episode is None or finding.episode not in other_units:
            yield finding


def _motion(contents: Contents, robot: list[Signal], pair: Pair | None) -> Iterator[Finding]:
    if pair is not None:
        yield from following(contents, pair)
        yield from pinned(contents, pair.action)
    for signal in robot:
        if signal.key == ACTION and pair is None:
            continue  # commands, which may go from one end to the other in a step
        yield from jumps(contents, signal)
        yield from noise(contents, signal)
