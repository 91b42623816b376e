"""Which of the choices beyond the paper carries a link: each set back alone, and all but each."""

from __future__ import annotations

from lfr.evaluation.evidence.aggregate import bootstrap, mean
from lfr.evaluation.evidence.names import LINKS, in_order
from lfr.evaluation.evidence.plain import of_same_seeds
from lfr.evaluation.evidence.published import TASKS
from lfr.evaluation.evidence.records import Evidence, Links
from lfr.evaluation.evidence.tables import link_cell, percent
from lfr.evaluation.tables import markdown

TITLE = "Which choice it is"
PARTS = {
    "demonstrations": "demonstrations undisturbed",
    "vae": "the VAE's",
    "prior": "the prior's",
    "mapping": "the mapping's",
}
"""Parts of the choices, as the stage plain_parts names them, and what they are called."""
ALL_BUT = "all_but_"
SAID = ("identity", "mapped")  # where AP begins, and LfR


def parts_section(evidence: Evidence) -> str | None:
    """A table for each transfer that was taken apart, and what it says; None if none was."""
    if not evidence.parts:
        return None
    found = [transfer for transfer in TASKS if transfer in evidence.parts]
    return "\n".join(
        f"{TASKS[transfer]}:\n\n{_table(evidence, transfer)}\n{_said(evidence, transfer)}"
        for transfer in found
    )


def _table(evidence: Evidence, transfer: str) -> str:
    """A row for each set of choices, from ours to the paper's reading; a column for each link."""
    parts, ours = evidence.parts[transfer], evidence.links.get(transfer)
    links = in_order((link for one in parts.values() for link in one.links), LINKS)
    (some, *_) = parts.values()
    same = [link_cell(of_same_seeds(ours, some, link), link) for link in links]
    names = in_order(parts, [*PARTS, *(f"{ALL_BUT}{part}" for part in PARTS)])
    plain = evidence.plain.get(transfer)
    rows = [
        ["nothing", *same],
        *([_label(name), *(link_cell(parts[name], link) for link in links)] for name in names),
        ["all", *(link_cell(plain, link) for link in links)],
    ]
    return markdown(["set back", *(f"`{link}`" for link in links)], rows)


def _label(name: str) -> str:
    part = name.removeprefix(ALL_BUT)
    said = PARTS.get(part, part)
    return said if part == name else f"all but {said}"


def _said(evidence: Evidence, transfer: str) -> str:
    """Of each of `SAID`, which part alone takes it down, and which alone brings it up again."""
    parts, sentences = evidence.parts[transfer], []
    ours, plain = evidence.links.get(transfer), evidence.plain.get(transfer)
    alone = {name: one for name, one in parts.items() if not name.startswith(ALL_BUT)}
    kept = {name: one for name, one in parts.items() if name.startswith(ALL_BUT)}
    for link in SAID:
        fall = _moved(ours, alone, link, "below")
        rise = _moved(plain, kept, link, "above")
        if fall is not None:
            sentences.append(f"`{link}` falls where one is set back alone: {fall}.")
        if rise is not None:
            sentences.append(f"`{link}` rises where one alone is not set back: {rise}.")
    return f"{' '.join(sentences)}\n" if sentences else ""


def _moved(before: Links | None, others: dict[str, Links], link: str, place: str) -> str | None:
    """``the prior's (99.0 to 50.0)``, for each whose interval is there; "none" if none is.

    None where nothing can be compared.
    """
    found, compared = [], 0
    for name in in_order(others, (*PARTS, *(f"{ALL_BUT}{part}" for part in PARTS))):
        same = of_same_seeds(before, others[name], link)
        if not same:
            continue
        compared += 1
        old, new = (bootstrap([one.links[link]], mean) for one in (same, others[name]))
        if new.beside(old) == place:
            part = PARTS.get(name.removeprefix(ALL_BUT), name)
            found.append(f"{part} ({percent(old.value)} to {percent(new.value)})")
    if not compared:
        return None
    return ", ".join(found) or f"none of {compared}"
