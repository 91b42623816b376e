"""What is left of a JSON object that was cut off."""

from __future__ import annotations

import json
from typing import Any

DEPTH = 2  # entries of the object itself, and of an object in it


def whole_entries(text: str) -> dict[str, Any]:
    """The entries of an object that are whole, and those of the last object in it.

    An entry is whole if a comma follows it: a number that the text ends with may have had more
    digits. Nothing is found where it is no object that was cut off.
    """
    open_, in_string, escaped, end = "", False, False, ""
    for i, c in enumerate(text):
        if in_string:
            in_string = escaped or c != '"'
            escaped = not escaped and c == "\\"
        elif c == '"':
            in_string = True
        elif c in "{[":
            open_ += c
        elif c in "}]":
            open_ = open_[:-1]
        elif c == "," and len(open_) <= DEPTH and "[" not in open_:
            end = text[:i] + "}" * len(open_)
    try:
        found = json.loads(end)
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}
