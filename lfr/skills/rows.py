"""How many rows of demonstrations are held at once: a bound on memory, far above fifty episodes."""

from __future__ import annotations

from torch import Tensor

MOST_ROWS = 2**19
"""Of one task: what is more adds memory, and nothing to what can be learned from it."""


def thinned(rows: Tensor) -> Tensor:
    """Every n-th of the rows (N, ...), so that at most `MOST_ROWS` are left: all of fewer."""
    return rows[:: -(-len(rows) // MOST_ROWS) or 1]
