"""The README's headline of the evidence: figure and targets, between two markers of its own."""

from __future__ import annotations

import re
from pathlib import Path

from lfr.artifacts import write_whole
from lfr.errors import DataError
from lfr.evaluation.evidence.findings import verdict
from lfr.evaluation.evidence.plain import plain_summary
from lfr.evaluation.evidence.published import PUBLISHED, TASKS
from lfr.evaluation.evidence.records import Evidence, read_evidence
from lfr.evaluation.evidence.summary import OURS, Summary, first_starts, summarise
from lfr.evaluation.evidence.tables import DASH, percent, percent_interval
from lfr.evaluation.evidence.targets import MARK, TARGETS, expected_rivals, standing
from lfr.evaluation.records import RESULTS
from lfr.evaluation.tables import markdown

BEGIN, END = "<!-- evidence -->", "<!-- /evidence -->"
NOT_YET = "*The evidence has not been gathered yet: `make paper` puts its headline here.*"


def evidence_block(results: Path = RESULTS) -> str:
    """The block that the README should show, from results/paper.

    Raises:
        DataError: a file there is damaged.
    """
    evidence = read_evidence(results / "paper")
    if not evidence.runs:
        return NOT_YET
    folder = f"{results.name}/paper"
    return "\n\n".join([
        f"![Final success of every method on the four transfers]({folder}/headline.svg)",
        _table(evidence).strip(),
        "Percent of held-out episodes over seeds, each of which repeats everything after the "
        "recording: mean, and interquartile mean (IQM) with its bootstrap interval of 95 %. Goal: "
        "the success that this project set out to reach. Zero-shot: before learning. Robosuite: "
        "the final policy in robosuite's own environments (Sawyer's contact with its base "
        f"excluded), on the first {first_starts(evidence)} starts only. Not below: methods whose "
        f"intervals overlap LfR's or lie above it; {MARK} marks those whose mean is lower all the "
        "same, by the interval of the difference. BC+RNN: a recurrent policy cloned from the "
        "source's demonstrations. AP: the source's policy, fine-tuned on the target without a "
        "mapping. Identity: the source's policy on the target, without mapping or learning. "
        "Recoded: its actions through the target's VAE. Shared VAE: one latent space for both "
        "arms.",
        *filter(None, [verdict(evidence), (plain_summary(evidence) or "").strip()]),
        f"Tables I to III, curves and questions: [report.md]({folder}/report.md).",
    ])  # fmt: skip


def _table(evidence: Evidence) -> str:
    header = ["task", "reward", "paper's LfR", "goal", "LfR, mean", "LfR, IQM", "seeds",
              "zero-shot", "robosuite", "not below"]  # fmt: skip
    rows = [
        [TASKS[transfer], reward, f"{PUBLISHED[transfer, OURS].rate:.1f}",
         f"{100 * target.success:.0f}", *_ours(evidence, transfer, reward)]
        for transfer, target in TARGETS.items()
        for reward in evidence.rewards()
    ]  # fmt: skip
    return markdown(header, rows)


def _ours(evidence: Evidence, transfer: str, reward: str) -> list[object]:
    found: Summary | None = summarise(evidence, transfer, OURS, reward)
    place = standing(evidence, transfer, reward)
    if found is None or place is None:
        return [DASH, DASH, 0, DASH, DASH, DASH]
    known = {**place.in_the_way, **place.below}
    others = place.named or "none"
    if not known.keys() >= set(expected_rivals(transfer, reward)):
        others = f"so far: {others}" if known else DASH
    return [percent(found.mean.value), percent_interval(found.iqm), len(found.seeds),
            percent(found.zero_shot), percent(found.stock), others]  # fmt: skip


def update_evidence(readme: Path, block: str) -> None:
    """Put ``block`` (Markdown) between the README's markers of the evidence.

    Raises:
        DataError: the markers are not there, or not once each and in order.
    """
    text, place = _find(readme)
    new = f"{text[: place.start()]}{BEGIN}\n{block}\n{END}{text[place.end() :]}"
    if new != text:
        with write_whole(readme) as partial:
            partial.write_text(new, encoding="utf-8")


def shown_evidence(readme: Path) -> str:
    """What stands between the markers now.

    Raises:
        DataError: as `update_evidence`.
    """
    return _find(readme)[1].group(1)


def _find(readme: Path) -> tuple[str, re.Match[str]]:
    text = readme.read_text(encoding="utf-8")
    places = list(re.finditer(f"{BEGIN}\n(.*?)\n?{END}", text, re.DOTALL))
    counts = [text.count(marker) for marker in (BEGIN, END)]
    if len(places) != 1 or counts != [1, 1]:
        raise DataError(
            "the markers of the evidence are not there once each",
            file=readme, found=counts, expected=f"one {BEGIN} and, after it, one {END}",
        )  # fmt: skip
    return text, places[0]
