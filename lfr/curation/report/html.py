"""A report as one HTML page, which needs nothing from elsewhere and runs no scripts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from lfr import __version__
from lfr.artifacts import write_whole
from lfr.curation.finding import Finding, Unreadable
from lfr.curation.kinds import KINDS
from lfr.curation.report.figures import Figures
from lfr.curation.report.svg import squares
from lfr.curation.report.words import by_kind, episodes_of, escaped, places, ranges
from lfr.curation.scores import BEST, Score
from lfr.curation.verify import Report

MOST = 5
"""Findings of each kind that are shown."""
WORST = 10  # episodes in the table of the worst
CELLS = 4000  # episodes that are drawn as a square each
STYLE = Path(__file__).with_name("page.css")
# Even what was not escaped could load nothing and run nothing.
POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"


def write_html(report: Report, path: Path) -> None:
    """Write the page, whole."""
    with write_whole(path) as partial:
        partial.write_text("\n".join(page(report)) + "\n", encoding="utf-8")


def page(report: Report) -> Iterator[str]:
    """The page's lines: its numbers, the episodes' scores, the kinds, and what is found of each."""
    name, scores = escaped(report.path.resolve().name), report.scores
    kinds = by_kind(report.findings)
    sound = [score.episode for score in scores if score.score == BEST]
    figures = None if report.contents is None else Figures(report.contents, sound)
    yield "<!doctype html>"
    yield '<html lang="en"><head><meta charset="utf-8">'
    yield f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
    yield '<meta name="viewport" content="width=device-width, initial-scale=1">'
    yield f"<title>{name}: lfr verify</title>"
    yield f"<style>{STYLE.read_text(encoding='utf-8')}</style></head><body><main>"
    yield f'<h1>{name}</h1><p class="quiet">{escaped(report)}</p>'
    yield from _numbers(report)
    if scores:
        yield from _episodes(scores)
    if kinds:
        yield from _table(kinds)
    for kind, findings in kinds.items():
        yield from _findings(kind, findings, figures)
    yield f'<footer class="quiet">lfr {escaped(__version__)}, lfr verify</footer>'
    yield "</main></body></html>"


def _numbers(report: Report) -> Iterator[str]:
    shown = {"episodes": f"{report.episodes}", "frames": f"{report.frames}"}
    if (fps := _fps(report)) is not None:
        shown["minutes"] = f"{report.frames / fps / 60:.1f}"
    shown |= {"errors": f"{len(report.errors)}", "warnings": f"{len(report.warnings)}"}
    if report.accepted:
        shown["accepted"] = f"{len(report.accepted)}"
    yield '<dl class="numbers">'
    for name, value in shown.items():
        kind = name if value != "0" and name in ("errors", "warnings") else ""
        yield f'<div class="{kind}"><dt>{name}</dt><dd>{value}</dd></div>'
    yield "</dl>"


def _fps(report: Report) -> float | None:
    try:
        return None if report.contents is None else report.contents.fps
    except Unreadable:
        return None


def _episodes(scores: Sequence[Score]) -> Iterator[str]:
    counts = Counter(score.score for score in scores)
    said = ", ".join(f"{counts[value]} score {value:g}" for value in sorted(counts, reverse=True))
    yield f"<section><h2>Episodes</h2><p>{said}.</p>"
    yield '<p class="quiet">An episode scores 1 where no finding names it and 0 where an error '
    yield "does; each kind of warning that names it halves its score.</p>"
    if 1 < len(scores) <= CELLS:
        yield squares(scores)
    worst = sorted((s for s in scores if s.score < BEST), key=lambda s: (s.score, s.episode))
    if worst:
        yield from _head("episode", "frames", "score", "kinds")
        for score in worst[:WORST]:
            kinds = ", ".join(_link(kind) for kind in score.kinds)
            yield f"<tr><td>{score.episode}</td><td>{score.frames}</td>"
            yield f"<td>{score.score:g}</td><td>{kinds}</td></tr>"
        yield "</tbody></table></div>"
    if len(worst) > WORST:
        yield f'<p class="quiet">and {len(worst) - WORST} more episodes with findings</p>'
    yield "</section>"


def _table(kinds: dict[str, list[Finding]]) -> Iterator[str]:
    yield '<section class="kinds"><h2>Findings by kind</h2>'
    yield from _head("kind", "severity", "findings", "episodes", "what it means")
    for kind, findings in kinds.items():
        yield f"<tr><td>{_link(kind)}</td><td>{_severity(findings[0])}</td>"
        yield f"<td>{len(findings)}</td><td>{len(episodes_of(findings)) or ''}</td>"
        yield f"<td>{escaped(KINDS.get(kind, ''))}</td></tr>"
    yield f'</tbody></table></div><p class="quiet">At most {MOST} of each kind are shown '
    yield "below.</p></section>"


def _findings(kind: str, findings: Sequence[Finding], figures: Figures | None) -> Iterator[str]:
    yield f'<section id="{escaped(kind)}"><h2>{escaped(kind)}</h2>'
    yield f'<p class="quiet">{escaped(KINDS.get(kind, ""))}</p>'
    for finding in findings[:MOST]:
        yield f"<article><h3>{_severity(finding)} {escaped(finding.message)}</h3><dl>"
        for name, text in places(finding).items():
            yield f"<div><dt>{name}</dt><dd>{escaped(text)}</dd></div>"
        yield "</dl>"
        if figures is not None:
            yield from figures.of(finding)
        yield "</article>"
    if rest := findings[MOST:]:
        named = ranges(episodes_of(rest))
        yield f"<p>and {len(rest)} more{f', of episodes {named}' if named else ''}</p>"
    yield "</section>"


def _head(*names: str) -> Iterator[str]:
    yield '<div class="wide"><table><thead><tr>'
    yield "".join(f'<th scope="col">{name}</th>' for name in names) + "</tr></thead><tbody>"


def _link(kind: str) -> str:
    return f'<a href="#{escaped(kind)}">{escaped(kind)}</a>'


def _severity(finding: Finding) -> str:
    return f'<span class="{finding.severity}">{finding.severity}</span>'
