"""What the evidence comes to, computed: does LfR need its mapping, its learning, its G?"""

from __future__ import annotations

from collections.abc import Iterable

from lfr.evaluation.evidence.aggregate import Seeds, bootstrap, difference
from lfr.evaluation.evidence.names import method_label
from lfr.evaluation.evidence.pairs import no_learning
from lfr.evaluation.evidence.plain import plain_sentence, reason_for_ap, reason_for_imitation
from lfr.evaluation.evidence.published import TASKS
from lfr.evaluation.evidence.records import Evidence, counts
from lfr.evaluation.evidence.reference import reference_sentence
from lfr.evaluation.evidence.summary import OURS, summarise
from lfr.evaluation.evidence.tables import (
    DASH,
    over_tasks,
    percent,
    percent_interval,
    points_interval,
)
from lfr.evaluation.evidence.targets import Rival, standing
from lfr.evaluation.tables import markdown

WITHOUT_MAPPING = {
    no_learning("identity"): "the source's prior and decoder, carried out by the target arm as "
    "they are, without mapping and without learning",
    method_label("bc_rnn"): "a recurrent policy cloned from the source's demonstrations, carried "
    "out by the target arm as it is",
    method_label("ap"): "the source's prior and decoder, fine-tuned on the target arm, without "
    "mapping",
    method_label("shared_vae"): "one VAE for both arms, so nothing to map, fine-tuned",
}
"""Who knows the source's demonstrations and maps nothing: label -> what they are."""


def short_table(evidence: Evidence) -> str:
    """LfR and what does without its mapping, a column for each task: IQM with its interval."""
    rows: list[list[object]] = []
    for method in (OURS, "ap", "shared_vae", "bc_rnn"):
        for reward in evidence.rewards():
            found = [evidence.of(transfer, method, reward) for transfer in TASKS]
            learned = any(run.reward for runs in found for run in runs)
            label = f"{method_label(method)}, {reward}" if learned else method_label(method)
            row = [label, *(_cell(counts(runs) if runs else None) for runs in found)]
            if row not in rows:  # one without a reward: once
                rows.append([*row])
    for label, link in (("LfR's start, no learning", "mapped"),
                        (no_learning("identity"), "identity"),
                        (no_learning("shared_vae"), "shared_vae")):  # fmt: skip
        rows.append([label, *(_cell(_link(evidence, transfer, link)) for transfer in TASKS)])
    measured = [row for row in rows if any(cell != DASH for cell in row[1:])]
    if not measured:
        return "Neither learning nor the zero-shot links have been run yet.\n"
    return markdown(["", *TASKS.values()], measured)


def findings(evidence: Evidence) -> str:
    """One item for each question that the evidence can answer so far."""
    items = [_rival(evidence, label, what) for label, what in WITHOUT_MAPPING.items()]
    items += [
        _learning(evidence), plain_sentence(evidence), _generator(evidence), _linear(evidence),
        _between_seeds(evidence),
    ]  # fmt: skip
    if evidence.reference:
        items.append(f"**Is this SAC a fair baseline?** {reference_sentence(evidence.reference)}")
    return "\n".join(f"- {item}" for item in items if item)


def _rival(evidence: Evidence, label: str, what: str) -> str | None:
    """Whether it is below LfR, over all tasks and rewards; None without a comparison."""
    points: list[float] = []
    places: dict[str, list[str]] = {"level": [], "above": [], "below": []}
    for transfer, task in TASKS.items():
        for reward in evidence.rewards():
            place = standing(evidence, transfer, reward)
            for name, named in places.items():
                one: Rival | None = getattr(place, name).get(label) if place else None
                if one:
                    theirs, ours = one.theirs.value, one.ours.value
                    points.append(100 * (theirs - ours))
                    named.append(f"{task}, {reward} ({percent(theirs)} against LfR's "
                                 f"{percent(ours)})")  # fmt: skip
    if not points:
        return None
    good, every = len(places["level"]) + len(places["above"]), len(points)
    verdict = (
        "is not below LfR, by overlapping or higher intervals," if good else "does worse than LfR"
    )
    share = f"in {good or every} of {every}"
    parts = [
        f"**{label[0].upper()}{label[1:]} {verdict} {share} "
        f"comparison{'s' * (every > 1)} of task and reward**: {what}. "
        f"Its interquartile mean is {_points(min(points), max(points))} LfR's.",
        _difference(evidence, label),
    ]
    for said, named in (("Better: ", places["above"]), ("Worse: ", places["below"])):
        parts += [f"{said}{'; '.join(named)}."] if named and good else []
    return " ".join(parts)


def _difference(evidence: Evidence, label: str) -> str:
    """How much more LfR's mean is, over all tasks."""
    parts = []
    for reward in evidence.rewards():
        found = over_tasks(evidence, reward).get(label)
        if found:
            ours, theirs = ([getattr(pair, side) for pair in found] for side in ("ours", "theirs"))
            parts.append(f"{points_interval(difference(ours, theirs))} points ({reward})")
    return f"LfR's mean less its own, over all tasks compared: {', '.join(parts)}."


def _points(low: float, high: float) -> str:
    """``1.0 points below to 2.7 above``, ``0.3 to 2.7 points above``; or one alone."""
    sizes = [f"{abs(end):.1f}" for end in (low, high)]
    sides = ["below" if end < 0 else "above" for end in (low, high)]
    if sides[0] != sides[1]:
        return f"{sizes[0]} points below to {sizes[1]} above"
    return f"{' to '.join(dict.fromkeys(sizes))} points {sides[0]}"


def _learning(evidence: Evidence) -> str | None:
    """What learning adds to where LfR starts."""
    parts = []
    for transfer, task in TASKS.items():
        for reward in evidence.rewards():
            ours = summarise(evidence, transfer, OURS, reward)
            if ours and ours.zero_shot is not None:
                parts.append(f"{task}, {reward}: {percent(ours.zero_shot)} to "
                             f"{percent(ours.mean.value)}")  # fmt: skip
    if not parts:
        return None
    return f"**What learning adds to LfR**, mean over seeds before and after: {'; '.join(parts)}."


def _generator(evidence: Evidence) -> str | None:
    """With G and without it, before learning."""
    parts = []
    for transfer, task in TASKS.items():
        with_g, without = (_link(evidence, transfer, link) for link in ("mapped", "no_generator"))
        if with_g and without:
            parts.append(f"{task}: {_cell(without)} without, {_cell(with_g)} with")
    if not parts:
        return None
    return (
        "**Without G and with it**, before any learning (links `no_generator` and `mapped`): "
        f"{'; '.join(parts)}."
    )


def _linear(evidence: Evidence) -> str | None:
    """A closed form in G's place, before learning, over the seeds that both have."""
    parts = []
    for transfer, task in TASKS.items():
        found = evidence.links.get(transfer)
        if not found or not {"linear", "mapped"} <= set(found.links):
            continue
        shared = set(found.seeds["linear"]) & set(found.seeds["mapped"])
        if shared:
            linear, same = (found.only(link, shared).links[link] for link in ("linear", "mapped"))
            parts.append(f"{task}: {_cell(linear)} linear, {_cell(same)} with G")
    if not parts:
        return None
    return (
        "**A closed-form linear map in G's place**, before any learning (links `linear` and "
        f"`mapped`, of the seeds that both have): {'; '.join(parts)}."
    )


def _between_seeds(evidence: Evidence) -> str | None:
    """One arm mapped onto itself: what of the problem is the latents' own arbitrariness."""
    parts = [
        f"{task}: {_cell(found)}"
        for transfer, task in TASKS.items()
        if (found := _link(evidence, transfer, "between_seeds"))
    ]
    if not parts:
        return None
    return (
        "**One arm, two VAE seeds** (link `between_seeds`): this mapping has nothing to bridge but "
        f"the latents' arbitrary coordinates. Success: {'; '.join(parts)}."
    )


def _link(evidence: Evidence, transfer: str, link: str) -> Seeds | None:
    found = evidence.links.get(transfer)
    return found.links.get(link) if found else None


def _cell(found: Seeds | None) -> str:
    return percent_interval(bootstrap([found])) if found else DASH


def reasons(evidence: Evidence, methods: Iterable[str]) -> str:
    """Why methods differ from the paper's figures, as far as something here was measured."""
    items = []
    starts = [
        f"{task} {percent(float(found.rates.mean()))}"
        for transfer, task in TASKS.items()
        if (found := _link(evidence, transfer, "identity"))
    ]
    if "ap" in methods and starts:
        items.append(
            "- AP begins as the link `identity`, whose mean success before any learning is "
            f"{', '.join(starts)}: under one Cartesian controller and one observation layout for "
            "both arms. The paper does not say where its AP begins."
        )
        items += filter(None, [reason_for_ap(evidence)])
    if "bc_rnn" in methods:
        items += filter(None, [reason_for_imitation(evidence)])
    if "sac" in methods and evidence.reference:
        items.append("- SAC: see its curve beside robosuite-benchmark's, above.")
    return "\n".join(items)
