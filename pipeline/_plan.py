"""In which order the stages of a pipeline run, several at a time, and how long that takes."""

from __future__ import annotations

from collections.abc import Collection, Mapping


class Plan:
    """Which stages are still to come, which run, and which have ended.

    How long a stage takes is foreseen, in the proportion that the stages already ended have taken
    here; one of which nothing is known counts nothing.

    Args:
        before: of each stage those that must have ended before it begins.
        foreseen: seconds of each stage.
        at_once: how many run at a time.
    """

    def __init__(
        self, before: Mapping[str, Collection[str]], foreseen: Mapping[str, float], at_once: int
    ) -> None:
        self._before = {
            stage: frozenset(earlier) & before.keys() for stage, earlier in before.items()
        }
        self._seconds = {stage: foreseen.get(stage, 0.0) for stage in before}
        self._at_once = at_once
        self._way = self._ways()
        self._waiting = sorted(before, key=lambda stage: -self._way[stage])
        self._ended: set[str] = set()
        self._took = self._expected = 0.0
        self.running: dict[str, float] = {}  # and when each began, in seconds on any clock

    @property
    def count(self) -> int:
        return len(self._before)

    @property
    def done(self) -> bool:
        return len(self._ended) == self.count

    def begin(self, now: float) -> str | None:
        """A stage that begins now; None while none can.

        Of those that can, it is the one from which the way to the end is the longest.
        """
        if len(self.running) < self._at_once:
            for stage in self._waiting:
                if self._before[stage] <= self._ended:
                    self._waiting.remove(stage)
                    self.running[stage] = now
                    return stage
        return None

    def end(self, stage: str, now: float, *, ran: bool = True) -> float:
        """A stage has ended; the seconds that it took.

        Args:
            ran: it was not found done already, which says nothing of this machine.
        """
        took = now - self.running.pop(stage)
        self._ended.add(stage)
        if ran and self._seconds[stage]:
            self._took, self._expected = self._took + took, self._expected + self._seconds[stage]
        return took

    def left(self, now: float) -> float:
        """Seconds until all have ended, where what can run does; 0 where nothing is known."""
        pace = self._took / self._expected if self._expected else 1.0
        ends = {
            stage: max(0.0, pace * self._seconds[stage] - (now - began))
            for stage, began in self.running.items()
        }
        ended, waiting, clock = set(self._ended), list(self._waiting), 0.0
        while ends or waiting:
            ready = (stage for stage in waiting if self._before[stage] <= ended)
            if len(ends) < self._at_once and (stage := next(ready, None)) is not None:
                waiting.remove(stage)
                ends[stage] = clock + pace * self._seconds[stage]
                continue
            first = min(ends, key=ends.__getitem__)
            clock = ends.pop(first)
            ended.add(first)
        return clock

    def _ways(self) -> dict[str, float]:
        """Seconds from each stage's beginning to the end of all that needs it, by foresight."""
        after: dict[str, list[str]] = {stage: [] for stage in self._before}
        for stage, earlier in self._before.items():
            for one in earlier:
                after[one].append(stage)
        ways: dict[str, float] = {}

        def way(stage: str) -> float:
            if stage not in ways:
                # even where nothing is known, what others wait for comes first
                ways[stage] = self._seconds[stage] + max(
                    (1e-3 + way(s) for s in after[stage]), default=0.0
                )
            return ways[stage]

        for stage in self._before:
            way(stage)
        return ways
