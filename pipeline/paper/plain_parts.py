"""Stage plain_parts: links of one transfer with one part of the choices set back, or all but it."""

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
    """Section ``plain_parts``.

    Attributes:
        transfers: that are taken apart.
        set_back: names of sets, see `parts_of`.
    """

    transfers: tuple[str, ...]
    set_back: tuple[str, ...]

    def __post_init__(self) -> None:
        for name, found in (("transfers", self.transfers), ("set_back", self.set_back)):
            if len(set(found)) != len(found):
                raise ParameterError(f"{name} must name each once, found {', '.join(found)}")
        for transfer in self.transfers:
            transfer_named(transfer)
        for name in self.set_back:
            parts_of(name)


def parts_of(name: str) -> list[str]:
    """The parts that are set back: ``<part>`` of `PARTS` itself, ``all_but_<part>`` the others.

    Raises:
        ParameterError: it names no part.
    """
    part = name.removeprefix(ALL_BUT)
    if part not in PARTS:
        raise ParameterError(
            f"set_back must be of {', '.join(PARTS)}, or {ALL_BUT}one, found {name!r}"
        )
    return [one for one in PARTS if (one == part) is (part == name)]


def main(transfer: str, set_back: str) -> None:
    """Train models for the seeds of ``questions`` and judge their links.

    The models stay where the unfinished work is; nothing else begins with them.
    """
    known = read_section(PartsParams, "plain_parts", PARAMS)
    if transfer not in known.transfers:
        raise UnknownNameError("transfer", transfer, known.transfers)
    if set_back not in known.set_back:
        raise UnknownNameError("set of parts", set_back, known.set_back)
    chosen, name, parts = transfer_named(transfer), f"{transfer}-{set_back}", parts_of(set_back)
    seeds, episodes = paper_seeds().questions, judging().episodes
    trained = train(chosen, choices(parts), seeds, "paper-plain-parts", name)
    links = judge(chosen, trained.folders, episodes, "paper-plain-parts-links", name)
    about = {"source": chosen.source, "target": chosen.target, "task": chosen.task}
    found = {"transfer": transfer, "set_back": parts, **about, "links": links, "runs": trained.runs}
    trained.spent.write("plain_parts", name, found)


if __name__ == "__main__":
    sys.exit(run_stage(main))
