"""What a finding looks like: curves of its columns, or frames of its video, as HTML."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from lfr.curation.contents import Contents
from lfr.curation.finding import Finding, Unreadable
from lfr.curation.report.curves import Curves, Panel
from lfr.curation.report.frames import PICTURED, chosen_frames, shots
from lfr.curation.report.svg import drawing, in_words
from lfr.curation.report.words import escaped
from lfr.errors import DataError


class Figures:
    """Figures of one dataset's findings.

    Args:
        contents: of the dataset.
        sound: episodes in which nothing is found, to compare with.
    """

    def __init__(self, contents: Contents, sound: Sequence[int]) -> None:
        self._contents, self._sound = contents, sound
        self._curves = Curves(contents, sound)

    def of(self, finding: Finding) -> Iterator[str]:
        """The figure as lines of HTML; none for a finding about no episode, or without a column
        that can be drawn; where something cannot be read, what.
        """
        if not finding.episodes:
            return
        episode = finding.episodes[0] if finding.episode is None else finding.episode
        try:
            rows = self._curves.rows(episode)
            if rows is None:
                return
            if finding.check not in PICTURED:
                yield from self._of_curves(finding, episode, rows)
            elif finding.column in self._contents.pictures():
                yield from self._of_frames(finding, finding.column, episode, rows)
        except (Unreadable, DataError, ValueError, IndexError) as error:
            yield f'<p class="quiet">No picture: {escaped(str(error)[:200])}</p>'

    def _of_curves(self, finding: Finding, episode: int, rows: slice) -> list[str]:
        panels, count = self._curves.panels(finding, episode)
        if not panels:
            return []
        fps, frames = self._contents.fps, rows.stop - rows.start
        shaded = self._curves.frames(finding, rows)
        if shaded == (0, frames - 1):
            shaded = None  # all of it needs no shade
        lines = ['<figure><div class="panels">']
        for panel in panels:
            lines.append(f"<div><h4>{escaped(panel.title)}</h4>")
            lines.append(f"{drawing(panel, fps, shaded, episode)}</div>")
        said = f"Episode {episode}, {frames} frames, {frames / fps:.3g} s"
        if shaded:
            said += f"; shaded: {in_words(shaded)}"
        if count > len(panels):
            said += f"; {count - len(panels)} more dimensions are not drawn"
        return [*lines, f"</div>{_legend(panels)}<figcaption>{said}</figcaption></figure>"]

    def _of_frames(self, finding: Finding, key: str, episode: int, rows: slice) -> list[str]:
        wanted = chosen_frames(finding, rows.stop - rows.start)
        lines = ["<figure>", *self._row(key, episode, wanted, "")]
        there = self._curves.there
        long = set(there.episode[there.length > wanted[-1]].tolist())
        others = [one for one in self._sound if one in long]
        if others:
            other = min(others, key=lambda one: abs(one - episode))
            lines += self._row(key, other, wanted, ", in which nothing is found")
        return [*lines, f"<figcaption>{escaped(key)}</figcaption></figure>"]

    def _row(self, key: str, episode: int, frames: list[int], words: str) -> Iterator[str]:
        yield f'<h4>Episode {episode}{words}</h4><div class="frames">'
        try:
            for shot in shots(self._contents, key, episode, frames):
                said = f"frame {shot.frame}, {shot.frame / self._contents.fps:.2f} s"
                seen = f"{escaped(key)} in episode {episode}, {said}"
                yield f'<div><img src="{shot.picture}" alt="{seen}"><p>{said}</p></div>'
        except DataError as error:  # what could be decoded stays
            yield f'<p class="quiet">No further frame: {escaped(error.message)}</p>'
        yield "</div>"


def _legend(panels: Sequence[Panel]) -> str:
    words = {line.role: escaped(line.name) for panel in panels for line in panel.lines}
    if any(panel.band is not None for panel in panels):
        words |= {"band": "5 to 95 % of other episodes", "median": "their median"}
    keys = [f'<span class="key {role}">{text}</span>' for role, text in words.items()]
    return f'<p class="legend">{" ".join(keys)}</p>' if len(keys) > 1 else ""
