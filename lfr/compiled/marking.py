"""Functions that belong to the compiled kernel, and the choice among them by number."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

MARKED: list[Callable[..., Any]] = []
"""What the kernel may call, in the order of definition; `lfr.sim.compilation` compiles it."""


def compiled[F: Callable[..., Any]](function: F) -> F:
    """Mark a function as one that the kernel may call; until then it is an ordinary function."""
    MARKED.append(function)
    return function


def select(
    functions: Sequence[Callable[..., Any]],
    number: Callable[..., int],
    otherwise: Callable[..., Any],
) -> Any:
    """One function that calls the ``number(scene)``-th of ``functions``.

    Compiled code has no lists of functions, so this is a chain of comparisons, built once.

    Args:
        functions: of the same arguments, the first two ``physics`` and ``scene``, and the same
            kind of result; all `compiled`.
        number: of a scene, which of them.
        otherwise: called where there is no such function.
    """
    chosen = otherwise
    for index in reversed(range(len(functions))):
        chosen = _either(index, number, functions[index], chosen)
    return chosen


def _either(
    index: int,
    number: Callable[..., int],
    one: Callable[..., Any],
    others: Callable[..., Any],
) -> Callable[..., Any]:
    def choose(physics: Any, scene: Any, *rest: Any) -> Any:
        if number(scene) == index:
            return one(physics, scene, *rest)
        return others(physics, scene, *rest)

    return compiled(choose)
