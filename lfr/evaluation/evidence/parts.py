"""Which part of the choices beyond the paper a link needs: one set back alone, and all but one."""

from __future__ import annotations

from collections.abc import Mapping

from lfr.evaluation.evidence.aggregate import bootstrap, mean
from lfr.evaluation.evidence.links import Links, same_seeds
from lfr.evaluation.evidence.names import LINKS, in_order
from lfr.evaluation.evidence.published import TASKS
from lfr.evaluation.evidence.records import Evidence
from lfr.evaluation.evidence.tables import link_cell, percent
from lfr.evaluation.tables import markdown

TITLE = "Which part of the choices"
PARTS = {
    "demonstrations": "noise, pushes and slips while the demonstrator acts, drifted starts",
    "execute": "how much of a skill is carried out before the next one",
    "vae": "the size of the latent space, augmented windows",
    "prior": "blurred inputs, moved copies of the demonstrations",
    "mapping": "blurred inputs, moved copies, the share of posteriors among the pairs",
}
"""The parts, as the stage plain_parts names them, and what each one is."""
# where AP begins, and LfR, each with the parts that can move it
SAID = {"identity": set(PARTS) - {"mapping"}, "mapped": set(PARTS)}
OWN_ARM = "own_arm"

Sets = Mapping[str, Links]
"""part -> links with this part set back alone, or with all but this one set back"""


def parts_section(evidence: Evidence) -> str | None:
    """What the parts are, and for each transfer that was taken apart a table and what it says.

    None if none was.
    """
    found = [transfer for transfer in TASKS if transfer in evidence.parts]
    if not found:
        return None
    about = "\n".join(f"- `{part}`: {what}" for part, what in PARTS.items())
    others = [task for transfer, task in TASKS.items() if transfer not in found]
    not_done = f"Not taken apart: {'; '.join(others)}.\n" if others else ""
    each = (
        f"{TASKS[transfer]}:\n\n{_table(evidence, transfer)}\n{_said(evidence, transfer)}"
        for transfer in found
    )
    return "\n".join([f"{about}\n", *each, not_done]).rstrip() + "\n"


def _sets(evidence: Evidence, transfer: str) -> tuple[Sets, Sets]:
    """Those with one part set back, and those with all but one."""
    alone, all_but = {}, {}
    for set_back, links in evidence.parts[transfer].items():
        kept = set(PARTS) - set(set_back)
        if len(set_back) == 1:
            alone[set_back[0]] = links
        elif len(kept) == 1:
            all_but[kept.pop()] = links
    return alone, all_but


def _table(evidence: Evidence, transfer: str) -> str:
    """A row for each set of choices, from ours to the paper's reading; a column for each link."""
    alone, all_but = _sets(evidence, transfer)
    rows: list[tuple[str, Links | None]] = [("nothing", evidence.links.get(transfer))]
    rows += [(f"`{part}`", alone[part]) for part in in_order(alone, PARTS)]
    rows += [(f"all but `{part}`", all_but[part]) for part in in_order(all_but, PARTS)]
    rows.append(("all", evidence.plain.get(transfer)))
    sets = [found for _, found in rows]
    links = in_order((link for one in (*alone.values(), *all_but.values()) for link in one.links),
                     LINKS)  # fmt: skip
    columns = [[link_cell(found, link) for found in same_seeds(link, sets)] for link in links]
    header = ["set back", *(f"`{link}`" for link in links)]
    names = (name for name, _ in rows)
    return markdown(header, [list(row) for row in zip(names, *columns, strict=True)])


def _said(evidence: Evidence, transfer: str) -> str:
    """Of each of `SAID`, what each part does: set back alone, and kept alone."""
    alone, all_but = _sets(evidence, transfer)
    sentences = []
    for link, parts in SAID.items():
        for before, sets, how in (
            (
                evidence.links.get(transfer),
                alone,
                "Compared with all our choices, with one part set back",
            ),
            (
                evidence.plain.get(transfer),
                all_but,
                "Compared with the paper's reading, with one part kept",
            ),
        ):
            moved = _moved(before, {p: one for p, one in sets.items() if p in parts}, link)
            if moved:
                sentences.append(f"- {how}, `{link}` is {moved}.\n")
    return "".join(sentences)


def _moved(before: Links | None, sets: Sets, link: str) -> str:
    """``below with `vae` (91.0 to 42.0); not told apart with `prior` (91.0 to 90.0)``

    With own_arm's rates behind what is below, where these were measured: the source itself may
    fail. By intervals of means over the same seeds; empty where nothing can be compared.
    """
    places: dict[str, list[str]] = {"below": [], "above": [], "level": []}
    for part in in_order(sets, PARTS):
        rates = _rates(before, sets[part], link)
        if rates:
            own = _rates(before, sets[part], OWN_ARM) if rates[2] == "below" else None
            said = f"{rates[0]} to {rates[1]}" + (f"; own arm {own[0]} to {own[1]}" if own else "")
            places[rates[2]].append(f"`{part}` ({said})")
    words = {"below": "below", "above": "above", "level": "not told apart"}
    return "; ".join(
        f"{words[place]} for {', '.join(found)}" for place, found in places.items() if found
    )


def _rates(before: Links | None, after: Links, link: str) -> tuple[str, str, str] | None:
    """Both means of a link, and where the second lies; None where one is missing."""
    pair = [one for one in same_seeds(link, [before, after]) if one]
    if len(pair) < 2:
        return None
    old, new = (bootstrap([one.links[link]], mean) for one in pair)
    return percent(old.value), percent(new.value), new.beside(old)
