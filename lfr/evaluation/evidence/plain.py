"""Links and learning once more, with the choices that go beyond the paper set back.

Plain is the paper's reading of what docs/method.md adds to it: section ``plain`` of
paper/params.yaml.
"""

from __future__ import annotations

from lfr.evaluation.evidence.aggregate import Interval, bootstrap, mean
from lfr.evaluation.evidence.links import Links, same_seeds
from lfr.evaluation.evidence.names import LINKS, METHODS, REWARDS, in_order, method_label
from lfr.evaluation.evidence.published import PUBLISHED, TASKS
from lfr.evaluation.evidence.records import Evidence, SeedRun, counts
from lfr.evaluation.evidence.summary import OURS
from lfr.evaluation.evidence.tables import DASH, link_cell, percent, percent_interval
from lfr.evaluation.tables import markdown

TITLE = "With our choices set back"
NOT_YET = "It has not been run yet.\n"
REFERENCES = {
    "own_arm": "the source on its own arm, no learning",
    "oracle": "the target with its own prior, no learning",
}
"""Links that say how good plain models are themselves."""


def plain_section(evidence: Evidence) -> str:
    """The links and what becomes of ``identity``; then who learned from there, and how far."""
    parts = [plain_table(evidence), identity_sentence(evidence), *learned(evidence)]
    return "\n".join(filter(None, parts))


def plain_table(evidence: Evidence) -> str:
    """Two rows for each link, a column for each transfer that has plain ones.

    Mean, its interval, and each seed, of the seeds that both have.
    """
    found = [transfer for transfer in TASKS if transfer in evidence.plain]
    if not found:
        return NOT_YET
    names = in_order((link for one in evidence.plain.values() for link in one.links), LINKS)
    rows: list[list[object]] = []
    for name in names:
        pairs = [_pair(evidence, transfer, name) for transfer in found]
        ours, plain = ([pair[place] for pair in pairs] for place in (0, 1))
        rows.append([f"`{name}`", "ours", *(link_cell(one, name) for one in ours)])
        rows.append(["", "plain", *(link_cell(one, name) for one in plain)])
    return markdown(["link", "choices", *(TASKS[transfer] for transfer in found)], rows)


def identity_sentence(evidence: Evidence) -> str | None:
    """On which tasks the source's own actions fail once all is plain, by intervals apart.

    None before both were measured on some task.
    """
    found: dict[str, list[str]] = {"below": [], "level": [], "above": []}
    every, own_arm = (both_means(evidence, link) for link in ("identity", "own_arm"))
    for transfer, (ours, plain) in every.items():
        change, place = change_of(ours, plain), plain.beside(ours)
        if place != "level" and transfer in own_arm:
            change += f"; the source on its own arm {change_of(*own_arm[transfer])}"
        found[place].append(f"{TASKS[transfer]} ({change})")
    if not every:
        return None
    count = f"{len(found['below'])} of {len(every)} task{'s' * (len(every) > 1)}"
    said = [f"With these choices set back `identity` falls on {count}{_named(found['below'])}."]
    if found["above"]:
        said.append(f"It rises on {len(found['above'])}{_named(found['above'])}.")
    if found["level"]:
        said.append(f"Its intervals overlap on {len(found['level'])}{_named(found['level'])}.")
    return f"{' '.join(said)}\n"


def learned(evidence: Evidence) -> list[str]:
    """A table of who learned from plain models or demonstrations, and LfR against the others."""
    runs = evidence.plain_runs
    if not runs:
        return []
    at = [transfer for transfer in TASKS if any(run.transfer == transfer for run in runs)]
    rows: list[list[object]] = []
    for method in in_order((run.method for run in runs), METHODS):
        learned_on = (run.reward or DASH for run in runs if run.method == method)
        for reward in in_order(learned_on, REWARDS):
            found = [evidence.plain_of(transfer, method, reward) for transfer in at]
            rows.append([method_label(method), reward, *map(_learned_cell, found)])
        published = (PUBLISHED.get((transfer, method), DASH) for transfer in at)
        rows.append(["", "paper", *published])
    about = (
        "What learning makes of these models: mean over seeds before it, and after it with its "
        "bootstrap interval, and each seed. Only demonstrations and models are plain; what else "
        "differs is section `learn_plain` of paper/params.yaml. Imitation has no such beginning.\n"
    )
    table = markdown(["method", "reward", *(TASKS[transfer] for transfer in at)], rows)
    return [about, table, *_against(evidence)]


def _learned_cell(runs: list[SeedRun]) -> str:
    """``9.3 to 85.3 [70.1, 95.2] (80, 91, 85)``; without a beginning, no ``9.3 to``"""
    if not runs:
        return DASH
    before = [run.zero_shot for run in runs if run.zero_shot is not None]
    began = f"{percent(sum(before) / len(before))} to " if len(before) == len(runs) else ""
    each = ", ".join(f"{100 * run.success:.0f}" for run in runs)
    return f"{began}{percent_interval(bootstrap([counts(runs)], mean))} ({each})"


def _against(evidence: Evidence) -> list[str]:
    """A sentence for each method beside LfR: on which tasks it ends below, level or above."""
    sentences = []
    runs = evidence.plain_runs
    for method in in_order((run.method for run in runs if run.method != OURS), METHODS):
        found: dict[str, list[str]] = {"below": [], "level": [], "above": []}
        for transfer, task in TASKS.items():
            for reward in REWARDS:
                ours, other = (evidence.plain_of(transfer, name, reward) for name in (OURS, method))
                if not ours or not other:
                    continue
                we, they = (bootstrap([counts(one)], mean) for one in (ours, other))
                points = f"{percent(they.value)} against {percent(we.value)}"
                found[they.beside(we)].append(f"{task}, {reward} ({points})")
        words = {"below": "below", "level": "not told apart from", "above": "above"}
        said = [
            f"{words[place]} LfR on {len(at)}: {', '.join(at)}" for place, at in found.items() if at
        ]
        if said:
            sentences.append(
                f"With our choices set back {method_label(method)} ends, by the intervals of these "
                f"means, {'; '.join(said)}.\n"
            )
    return sentences


def plain_summary(evidence: Evidence) -> str | None:
    """Where LfR, BC+RNN and AP end with our choices set back, beside the paper's; None before.

    With what the models reach before learning on the source's own arm and with the target's own
    prior: where these are low, no transfer can do well.
    """
    found = [t for t in TASKS if any(run.transfer == t for run in evidence.plain_runs)]
    if not found:
        return None
    rows: list[list[object]] = []
    for method in (OURS, "bc_rnn", "ap"):
        for reward in (None, *REWARDS):
            cells = [plain_end(evidence, transfer, method, reward) for transfer in found]
            if any(cell != DASH for cell in cells):
                label = f"{method_label(method)}, {reward}" if reward else method_label(method)
                papers = (f"{PUBLISHED[transfer, method].rate:.1f}" for transfer in found)
                both = zip(cells, papers, strict=True)
                rows.append([label, *(cell for pair in both for cell in pair)])
    for link, label in REFERENCES.items():
        cells = [_link_mean(evidence, transfer, link) for transfer in found]
        if any(cell != DASH for cell in cells):
            rows.append([label, *(one for cell in cells for one in (cell, DASH))])
    header = ["", *(name for transfer in found for name in (TASKS[transfer], "paper"))]
    return (
        "**With most of the choices that go beyond the paper set back**, mean over seeds with its "
        f"interval:\n\n{markdown(header, rows)}\n{_rests(evidence)}This is no replication of the "
        "paper: what it does not state had to be chosen, some choices stay, and all values were "
        "chosen with the others in place.\n"
    )


def plain_end(evidence: Evidence, transfer: str, method: str, reward: str | None) -> str:
    """``43.7 [2.7, 74.3]``; a dash where it was not run under this reward."""
    runs = [run for run in evidence.plain_runs
            if (run.transfer, run.method, run.reward) == (transfer, method, reward)]  # fmt: skip
    return percent_interval(bootstrap([counts(runs)], mean)) if runs else DASH


def _link_mean(evidence: Evidence, transfer: str, link: str) -> str:
    found = evidence.plain.get(transfer)
    if not found or link not in found.links:
        return DASH
    return percent_interval(bootstrap([found.links[link]], mean))


def _rests(evidence: Evidence) -> str:
    """On how many tasks LfR's rates need our choices: below them by intervals of means."""
    places = []
    for transfer in TASKS:
        both = [
            [bootstrap([counts(runs)], mean) for runs in (plain, ours)]
            for reward in REWARDS
            if (plain := evidence.plain_of(transfer, OURS, reward))
            and (ours := evidence.of(transfer, OURS, reward))
        ]
        if both:
            places.append(all(plain.beside(ours) == "below" for plain, ours in both))
    if not places:
        return ""
    return (
        f"LfR's success rests on these choices on {sum(places)} of {len(places)} of these tasks. "
    )


def _named(tasks: list[str]) -> str:
    return f": {', '.join(tasks)}" if tasks else ""


def change_of(ours: Interval, plain: Interval) -> str:
    """``97.0 to 19.3``"""
    return f"{percent(ours.value)} to {percent(plain.value)}"


def both_means(evidence: Evidence, link: str) -> dict[str, tuple[Interval, Interval]]:
    """transfer -> the link's mean with our choices and with plain ones, over the same seeds."""
    found = {}
    for transfer in TASKS:
        ours, plain = _pair(evidence, transfer, link)
        if ours and plain:
            before, after = (bootstrap([one.links[link]], mean) for one in (ours, plain))
            found[transfer] = before, after
    return found


def _pair(evidence: Evidence, transfer: str, link: str) -> list[Links | None]:
    """A link of ours and the plain one, of the seeds that both have."""
    return same_seeds(link, [evidence.links.get(transfer), evidence.plain.get(transfer)])
