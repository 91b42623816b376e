"""Zero-shot links: success before any learning, a count per seed."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

from lfr.evaluation.evidence.aggregate import Seeds
from lfr.evaluation.evidence.names import LINKS, in_order


@dataclass(frozen=True)
class Links:
    """A transfer's zero-shot links, each with a success count per seed, by rising seed.

    Attributes:
        seeds: which ones, of each link.
    """

    transfer: str
    links: dict[str, Seeds]
    seeds: dict[str, tuple[int, ...]]

    def only(self, link: str, seeds: Collection[int]) -> Links:
        """This link alone, of those seeds."""
        found = self.links[link]
        places = [place for place, seed in enumerate(self.seeds[link]) if seed in seeds]
        kept = Seeds(
            tuple(found.successes[place] for place in places),
            tuple(found.episodes[place] for place in places),
        )
        return Links(
            self.transfer, {link: kept}, {link: tuple(self.seeds[link][place] for place in places)}
        )


def same_seeds(link: str, found: Sequence[Links | None]) -> list[Links | None]:
    """Each with this link alone, of the seeds that all share who have it.

    None in the place of one that lacks the link; in all places where no seed is shared.
    """
    seeds = [set(one.seeds[link]) for one in found if one and link in one.links]
    shared = set.intersection(*seeds) if seeds else set[int]()
    return [
        one.only(link, shared) if shared and one and link in one.links else None for one in found
    ]


def links_of(content: dict[str, Any]) -> Links:
    """Of a stage's file, as it is read; a link that no seed has is left out."""
    links, seeds = {}, {}
    for name in in_order(content["links"], LINKS):
        runs = sorted(content["links"][name]["runs"], key=lambda run: run["seed"])
        if runs:
            found, tried = (tuple(run[key] for run in runs) for key in ("successes", "episodes"))
            links[name] = Seeds(found, tried)
            seeds[name] = tuple(run["seed"] for run in runs)
    return Links(content["transfer"], links, seeds)
