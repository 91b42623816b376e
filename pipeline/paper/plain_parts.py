"""Stage plain_parts: which of the choices beyond the paper carries a transfer's links."""

import sys
from dataclasses import dataclass

from lfr.errors import ParameterError, UnknownNameError
from lfr.params import read_section
from lfr.program import run_stage
from lfr.scenarios import transfer as transfer_named
from pipeline.paper._choices import PARTS, choices, judge, train
from pipeline.paper._stage import PARAMS, judging, paper_seeds

ALL_BUT = "all_but_"


@dataclass(frozen=True)
class PartsParams:
    """Section ``plain_parts``: what is set back to the paper's reading, and on which transfers.

    Attributes:
        plain: one of `pipeline.paper._choices.PARTS` each, alone, or ``all_but_<part>``.
    """

    transfers: tuple[str, ...]
    plain: tuple[str, ...]

    def __post_init__(self) -> None:
        for transfer in self.transfers:
            transfer_named(transfer)
        for name in self.plain:
            parts_of(name)


def parts_of(plain: str) -> set[str]:
    """The parts that a name of ``plain`` sets back.

    Raises:
        ParameterError: it names no part.
    """
    part = plain.removeprefix(ALL_BUT)
    if part not in PARTS:
        raise ParameterError(f"plain must be of {', '.join(PARTS)}, or {ALL_BUT}one, found {plain}")
    return {one for one in PARTS if (one == part) is (part == plain)}


def main(transfer: str, plain: str) -> None:
    """Train models for the seeds of ``questions``, judge their links, and keep no model.

    A part alone says whether the links need our choice where they have all the others; all but a
    part, whether that choice is enough where they have none else.
    """
    chosen, known = transfer_named(transfer), read_section(PartsParams, "plain_parts", PARAMS)
    if plain not in known.plain:
        raise UnknownNameError("choice", plain, known.plain)
    name, seeds = f"{transfer}-{plain}", paper_seeds().questions
    trained = train(chosen, choices(parts_of(plain)), seeds, "paper-plain-parts", name)
    episodes = judging().episodes
    links = judge(chosen, trained.folders, episodes, "paper-plain-parts-links", name)
    about = {"source": chosen.source, "target": chosen.target, "task": chosen.task}
    found = {"transfer": transfer, "plain": plain, **about, "links": links, "runs": trained.runs}
    trained.spent.write("plain_parts", name, found)


if __name__ == "__main__":
    sys.exit(run_stage(main))
