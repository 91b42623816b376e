"""The Markdown that cards are made of."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any


def table(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table; a cell's own bars are escaped."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(_cell(cell) for cell in line)} |" for line in lines)


def card(header: Any, *parts: str) -> str:
    """A card: the YAML header (one of huggingface_hub's CardData) and its parts, a line apart."""
    body = "\n\n".join(part.strip() for part in parts if part.strip())
    return f"---\n{header.to_yaml()}\n---\n\n{body}\n"


def python(*lines: str) -> str:
    return "\n".join(("```python", *lines, "```"))


def shell(*lines: str) -> str:
    return "\n".join(("```sh", *lines, "```"))


def _cell(cell: object) -> str:
    return str(cell).replace("|", "\\|")
