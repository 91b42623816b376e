"""What the evidence comes to, computed: does LfR need its mapping, its learning, its G?"""

from __future__ import annotations

from lfr.evaluation.evidence.aggregate import Place, Seeds, bootstrap, difference
from lfr.evaluation.evidence.names import method_label
from lfr.evaluation.evidence.pairs import no_learning
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
from lfr.evaluation.evidence.targets import standing
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
        rows.append([label, *(_cell(evidence.link(transfer, link)) for transfer in TASKS)])
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
    found = [
        (task, reward, rival)
        for transfer, task in TASKS.items()
        for reward in evidence.rewards()
        if (place := standing(evidence, transfer, reward))
        and (rival := {**place.in_the_way, **place.below}.get(label))
    ]
    if not found:
        return None
    places: dict[Place, list[str]] = {"below": [], "level": [], "above": []}
    for task, reward, rival in found:
        theirs, ours = percent(rival.theirs.value), percent(rival.ours.value)
        places[rival.place].append(f"{task}, {reward} ({theirs} against LfR's {ours})")
    every, worse, tasks = len(found), len(places["below"]), len({task for task, *_ in found})
    said, share = (
        ("does worse than LfR", every)
        if worse == every
        else ("is not below LfR, by overlapping or higher intervals,", every - worse)
    )
    points = [100 * (rival.theirs.value - rival.ours.value) for *_, rival in found]
    ahead = [f"{task}, {reward} ({points_interval(rival.lead)})"
             for task, reward, rival in found if rival.mark]  # fmt: skip
    listed = {
        "Yet by the means LfR is ahead on": ahead,
        "Better": places["above"],
        "Worse": places["below"] if worse < every else [],
    }
    return " ".join([
        f"**{label[0].upper()}{label[1:]} {said} in {share} of {every} "
        f"comparison{'s' * (every > 1)}** ({tasks} task{'s' * (tasks > 1)}, LfR under each "
        f"reward): {what}. Its interquartile mean is {_points(min(points), max(points))} LfR's.",
        _difference(evidence, label),
        *(f"{title}: {'; '.join(named)}." for title, named in listed.items() if named),
    ])  # fmt: skip


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
        with_g, without = (evidence.link(transfer, link) for link in ("mapped", "no_generator"))
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
        if (found := evidence.link(transfer, "between_seeds"))
    ]
    if not parts:
        return None
    return (
        "**One arm, two VAE seeds** (link `between_seeds`): this mapping has nothing to bridge but "
        f"the latents' arbitrary coordinates. Success: {'; '.join(parts)}."
    )


def _cell(found: Seeds | None) -> str:
    return percent_interval(bootstrap([found])) if found else DASH
