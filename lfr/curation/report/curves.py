"""The curves that show what a finding says of an episode: its columns over time, and the others'.

A panel is one dimension. Behind its curve lies what the other episodes do, each stretched to this
one's length; where a finding is about state and action both, they are side by side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfr.curation.contents import DEFAULT_FEATURES, Contents, Runs, runs
from lfr.curation.finding import Finding
from lfr.data.episode import ACTION, STATE
from lfr.data.features import names_of

PANELS = 6  # dimensions that are drawn of a finding
FEWEST = 5  # episodes of which a band says something
POINTS = 64  # of an episode's time
BAND = (0.05, 0.5, 0.95)
PAIRED = ("tracking", "lag", "stuck", "copied", "pinned", "unit")
"""Kinds that are about how a state goes with its action."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Line:
    """(T,) values under a name; `role` is `own`, `action`, `other` or `expected`."""

    name: str
    values: Array
    role: str = "own"


@dataclass(frozen=True)
class Panel:
    """One dimension of an episode.

    Attributes:
        title: of the dimension.
        lines: the episode's, first, and what goes with it.
        band: (3, POINTS) the 5 %, 50 % and 95 % of the other episodes, over the whole of their
            time; None where they say nothing.
    """

    title: str
    lines: tuple[Line, ...]
    band: Array | None = None


@dataclass
class Curves:
    """Curves of one dataset; each column is read once.

    Attributes:
        contents: of the dataset.
        sound: episodes in which nothing is found, of which the bands are where they are enough.
    """

    contents: Contents
    sound: Sequence[int] = ()
    _values: dict[str, Array] = field(default_factory=dict)
    _bands: dict[tuple[str, int], Array] = field(default_factory=dict)

    @cached_property
    def there(self) -> Runs:
        return runs(self.contents)

    def rows(self, episode: int) -> slice | None:
        """An episode's rows; None where it has none."""
        places = np.flatnonzero(self.there.episode == episode)
        if not len(places):
            return None
        start = int(self.there.start[places[0]])
        return slice(start, start + int(self.there.length[places[0]]))

    def frames(self, finding: Finding, rows: slice) -> tuple[int, int] | None:
        """First and last frame of the episode that a finding is about."""
        if finding.frames is not None:
            return finding.frames
        if finding.row is None or not rows.start <= finding.row < rows.stop:
            return None
        return finding.row - rows.start, finding.row - rows.start

    def panels(self, finding: Finding, episode: int) -> tuple[list[Panel], int]:
        """What to draw, and of how many dimensions that is.

        Raises:
            Unreadable: a column that cannot be read.
        """
        rows = self.rows(episode)
        if rows is None:
            return [], 0
        key, dimensions = self._chosen(finding, rows)
        if key is None:
            return [], 0
        other = self._same_as(finding)
        panels = [self._panel(finding, key, i, rows, other) for i in dimensions[:PANELS]]
        return panels, len(dimensions)

    def _panel(self, finding: Finding, key: str, i: int, rows: slice, other: slice | None) -> Panel:
        own, names = self.values(key)[rows, i], self._names(key)
        title = names[i] if names[i].startswith(key) else f"{key}: {names[i]}"
        if key == "timestamp":
            expected = np.arange(len(own)) / self.contents.fps
            return Panel("timestamp (s)", (Line("timestamp", own),
                                           Line("frame / fps", expected, "expected")))  # fmt: skip
        if key in DEFAULT_FEATURES:
            return Panel(title, (Line(title, own),))
        partner = {ACTION: STATE, STATE: ACTION}.get(key)
        if finding.check in PAIRED and partner in self.contents.features:
            beside = self._names(partner)
            if names[i] in beside and not names[i].isdigit():
                values = self.values(partner)[rows, beside.index(names[i])]
                state, action = (own, values) if key == STATE else (values, own)
                return Panel(names[i], (Line("state", state), Line("action", action, "action")))
        lines = [Line("this episode", own)]
        if other is not None:
            lines.append(Line(str(finding.found), self.values(key)[other, i][: len(own)], "other"))
        return Panel(title, tuple(lines), self.band(key, i, rows))

    def band(self, key: str, i: int, rows: slice) -> Array | None:
        """(3, POINTS) of a dimension, of the sound episodes, or of all others than that of `rows`
        where the sound ones are few; None where these are few too.
        """
        there = self.there
        chosen = np.isin(there.episode, list(self.sound)) & (there.length > 1)
        of_all = chosen.sum() >= FEWEST
        if not of_all:
            chosen = (there.start != rows.start) & (there.length > 1)
        if chosen.sum() < FEWEST:
            return None
        if of_all and (key, i) in self._bands:
            return self._bands[key, i]
        time = np.linspace(0, there.length[chosen] - 1, POINTS).round().astype(np.int64)
        values = self.values(key)[there.start[chosen] + time, i].T  # (E, POINTS)
        values = values[np.isfinite(values).all(axis=1)]
        if len(values) < FEWEST:
            return None
        band = np.quantile(values, BAND, axis=0)
        if of_all:
            self._bands[key, i] = band
        return band

    def values(self, key: str) -> Array:
        """(N, D) a column of numbers."""
        if key not in self._values:
            column = self.contents.column(key)
            self._values[key] = np.asarray(column, np.float64).reshape(len(column), -1)
        return self._values[key]

    def _names(self, key: str) -> list[str]:
        """What each dimension is called; its number where it has no name."""
        size, names = self.values(key).shape[1], names_of(self.contents.features[key])
        if len(names) == size and size > 1:
            return names
        return [key] if size == 1 else [str(i) for i in range(size)]

    def _chosen(self, finding: Finding, rows: slice) -> tuple[str | None, list[int]]:
        """The column that a finding names, and its dimensions; of one that names none, what is
        observed.
        """
        numeric, column = self.contents.numeric(), finding.column or ""
        if not column:
            observed = [STATE, *(k for k in numeric if k.startswith("observation.")), ACTION]
            key = next((k for k in observed if k in numeric), None)
            return key, [] if key is None else self._telling(key, rows)
        if column.startswith("stats/"):
            column = column.removeprefix("stats/").rpartition("/")[0]
        for key in sorted(numeric, key=len, reverse=True):
            if column == key:
                return key, self._telling(key, rows)
            if not column.startswith(key):
                continue
            named = column[len(key) :]
            names = self._names(key)
            wanted = named.removeprefix(": ").split(", ") if named.startswith(": ") else [
                named.removeprefix(".").strip("[]")
            ]  # fmt: skip
            dimensions = [names.index(name) for name in wanted if name in names]
            if not dimensions and wanted[0].isdecimal() and int(wanted[0]) < len(names):
                dimensions = [int(wanted[0])]
            if dimensions:
                return key, dimensions
        return None, []

    def _telling(self, key: str, rows: slice) -> list[int]:
        """All dimensions, those first that have gaps here, then those that move anywhere."""
        values = self.values(key)
        gaps = ~np.isfinite(values[rows]).all(axis=0)
        still = (values == values[:1]).all(axis=0)
        order: Any = np.lexsort((np.arange(values.shape[1]), still, ~gaps))
        return order.tolist()

    def _same_as(self, finding: Finding) -> slice | None:
        """The rows of the episode that a duplicate is the same as."""
        word, _, number = str(finding.found).partition(" ")
        if finding.check != "duplicate" or word != "episode" or not number.isdecimal():
            return None
        return self.rows(int(number))
