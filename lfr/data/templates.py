"""Names of a dataset's files, as info.json says them: format strings that hold indices and a key.

A dataset may be anybody's, so that no more is carried out of such a string than LeRobot's own have:
`str.format` would read attributes, and write gigabytes for a width.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from string import Formatter

SPECS = re.compile(r"(0?\d{1,2})?d?")  # what may stand after the colon, as in {chunk_index:03d}


def file_name(template: object, **values: int | str) -> str:
    """The name that a format string gives.

    Raises:
        ValueError: it is no such string, or names what is not among the values.
    """
    return "".join(
        text + ("" if name is None else format(values[name], spec))
        for text, name, spec in _parts(template, values)
    )


def renamed(template: object, names: Mapping[str, str]) -> str:
    """A format string whose fields are called otherwise, by their names until now.

    Raises:
        ValueError: as `file_name`.
    """
    return "".join(
        _escaped(text) + ("" if name is None else f"{{{names[name]}{':' * bool(spec)}{spec}}}")
        for text, name, spec in _parts(template, names)
    )


def _parts(template: object, known: Mapping[str, object]) -> list[tuple[str, str | None, str]]:
    if not isinstance(template, str):
        raise ValueError("no format string")
    parts = []
    for text, name, spec, conversion in Formatter().parse(template):
        if name is not None and (
            conversion or name not in known or not SPECS.fullmatch(spec or "")
        ):
            asked = name + (f"!{conversion}" if conversion else "") + (f":{spec}" if spec else "")
            raise ValueError(f"{{{asked}}}, not one of {', '.join(known)} as a number of digits")
        parts.append((text, name, spec or ""))
    return parts


def _escaped(text: str) -> str:
    return text.replace("{", "{{").replace("}", "}}")
