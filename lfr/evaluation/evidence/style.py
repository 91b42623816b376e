"""How a method looks in every figure: a colour, a line and a mark."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

STYLE: dict[Any, Any] = {
    "svg.hashsalt": "lfr",  # the same figure, the same bytes
    "svg.fonttype": "path",  # the same letters everywhere
    "font.family": "DejaVu Sans",  # matplotlib's own
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.edgecolor": "#555555",
    "xtick.color": "#333333",
    "ytick.color": "#333333",
    "legend.frameon": False,
}
PERCENT = ([0, 0.25, 0.5, 0.75, 1], ["0", "", "50", "", "100 %"])


@dataclass(frozen=True)
class Look:
    """Colour (of Okabe and Ito 2008, told apart by the colour-blind), line style and marker."""

    color: str
    line: Any = "-"
    marker: str = "o"


LOOKS = {
    "lfr": Look("#0072B2"),
    "bc_rnn": Look("#000000", (0, (4, 2)), "X"),
    "ap": Look("#D55E00", (0, (6, 1.5, 1, 1.5)), "s"),
    "sac": Look("#E69F00", (0, (1.2, 1.2)), "^"),
    "no_generator": Look("#000000", (0, (1.2, 1.2)), "v"),
    "only_lift": Look("#CC79A7", (0, (4, 2)), "D"),
    "only_nut_assembly": Look("#009E73", (0, (6, 1.5, 1, 1.5)), "P"),
    "only_pick_place": Look("#56B4E9", (0, (4, 2)), "h"),
    "shared_vae": Look("#D55E00", (0, (6, 1.5, 1, 1.5)), "p"),
    "spirl": Look("#009E73", (0, (4, 2)), "<"),
    "spirl_no_prior": Look("#56B4E9", (0, (1.2, 1.2)), ">"),
    "wrong_task": Look("#CC79A7", (0, (8, 2)), "d"),
}
OTHER = Look("#777777", (0, (3, 1)), "*")


def look(method: str) -> Look:
    """A method's look; grey where it has none of its own."""
    return LOOKS.get(method, OTHER)
