"""What the evidence comes to, computed: does LfR need its mapping, its learning, its G?"""

from __future__ import annotations

from collections.abc import Iterable

from lfr.evaluation.evidence.aggregate import Place, Seeds, bootstrap, difference
from lfr.evaluation.evidence.names import method_label
from lfr.evaluation.evidence.pairs import no_learning
from lfr.evaluation.evidence.plain import reason_for_ap, reason_for_imitation
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
IN_PLACE_OF_G = {
    "linear": "A closed-form linear map in G's place",
    "no_cycle": "G without the cycle loss",
}
"""Links that map otherwise than G does."""


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
        _learning(evidence), _generator(evidence),
        *(_in_place_of_g(evidence, link, what) for link, what in IN_PLACE_OF_G.items()),
        _between_seeds(evidence),
    ]  # fmt: skip
    if evidence.reference:
        items.append(
            f"**Is this SAC a fair baseline?** {reference_sentence(evidence.reference)} That says "
            "nothing of the sparse reward."
        )
    return "\n".join(f"- {item}" for item in items if item)


def verdict(evidence: Evidence) -> str | None:
    """On how many tasks these results cannot show what a mapping is worth; None without identity.

    A task counts where `identity` is level with LfR or above it under every reward measured.
    """
    label, places = no_learning("identity"), []
    for transfer in TASKS:
        found = [standing(evidence, transfer, reward) for reward in evidence.rewards()]
        beside = [place for place in found if place and label in place.in_the_way | place.below]
        if beside:
            places.append(all(label in place.in_the_way for place in beside))
    if not places:
        return None
    return (
        f"**On {sum(places)} of {len(places)} task{'s' * (len(places) > 1)} LfR's interquartile "
        "mean cannot be told from that of `identity`**, the source's policy carried out by the "
        "target, without mapping and without learning: there these results do not show what a "
        "mapping between the arms is worth."
    )


def _rival(evidence: Evidence, label: str, what: str) -> str | None:
    """Whether it is below LfR, over all tasks and rewards; None without a comparison."""
    points: list[float] = []
    places: dict[str, list[str]] = {"level": [], "above": [], "below": []}
    behind, tasks = [], set()
    for transfer, task in TASKS.items():
        for reward in evidence.rewards():
            place = standing(evidence, transfer, reward)
            for name, named in places.items():
                one: Rival | None = getattr(place, name).get(label) if place else None
                if one:
                    tasks.add(task)
                    theirs, ours = one.theirs.value, one.ours.value
                    points.append(100 * (theirs - ours))
                    named.append(f"{task}, {reward} ({percent(theirs)} against LfR's "
                                 f"{percent(ours)})")  # fmt: skip
                    if one.mark:
                        behind.append(f"{task}, {reward} ({points_interval(one.lead)})")
    if not points:
        return None
    good, every = len(places["level"]) + len(places["above"]), len(points)
    verdict = (
        "is not below LfR, by overlapping or higher intervals," if good else "does worse than LfR"
    )
    share = f"in {good or every} of {every}"
    parts = [
        f"**{label[0].upper()}{label[1:]} {verdict} {share} "
        f"comparison{'s' * (every > 1)}** ({len(tasks)} task{'s' * (len(tasks) > 1)}, LfR under "
        f"each reward): {what}. "
        f"Its interquartile mean is {_points(min(points), max(points))} LfR's.",
        _difference(evidence, label),
    ]
    if behind:
        parts.append(f"Yet by the means LfR is ahead on: {'; '.join(behind)}.")
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


def _in_place_of_g(evidence: Evidence, link: str, what: str) -> str | None:
    """Another map, before learning, over the seeds that it and G have."""
    parts: list[str] = []
    places: list[Place] = []
    for transfer, task in TASKS.items():
        found = evidence.links.get(transfer)
        if not found or not {link, "mapped"} <= set(found.links):
            continue
        shared = set(found.seeds[link]) & set(found.seeds["mapped"])
        if shared:
            other, g = (found.only(name, shared).links[name] for name in (link, "mapped"))
            parts.append(f"{task}: {_cell(other)}, G {_cell(g)}")
            places.append(bootstrap([other]).beside(bootstrap([g])))
    if not parts:
        return None
    words: dict[Place, str] = {"above": "above", "level": "not told apart from", "below": "below"}
    said = [f"{word} G on {places.count(one)}" for one, word in words.items() if one in places]
    return (
        f"**{what}**, before any learning (links `{link}` and `mapped`, of the seeds that both "
        f"have), is {', '.join(said)} of {len(places)} task{'s' * (len(places) > 1)}: "
        f"{'; '.join(parts)}."
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
        f"{task}: {percent(float(found.rates.mean()))}"
        for transfer, task in TASKS.items()
        if (found := _link(evidence, transfer, "identity"))
    ]
    if "ap" in methods and starts:
        items.append(
            "- AP begins as the link `identity`, whose mean success before any learning is "
            f"{'; '.join(starts)}. Both arms have one Cartesian controller and one observation "
            "layout here. The paper does not say where its AP begins."
        )
        items += filter(None, [reason_for_ap(evidence)])
    if "bc_rnn" in methods:
        items += filter(None, [reason_for_imitation(evidence)])
    if "sac" in methods and evidence.reference:
        items.append(
            "- SAC: with the dense reward its curve stands beside robosuite-benchmark's, above. "
            "With the sparse one nothing was measured that would explain the difference; which "
            "reward and how many steps the paper's SAC had, it does not say."
        )
    return "\n".join(items)
