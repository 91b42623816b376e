"""Numbers out of a message by a dotted path, and what each of them is called.

`position` of a JointState are numbers named by the joints beside them; `pose` of a PoseStamped is a
message, all of whose numbers are taken, named by their own paths (`position.x`);
`points[0].positions` goes into a list; `joints.position` takes a field of every message in a list,
named by their `name`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from itertools import chain
from typing import Any

from lfr.importing.bag.decoding import (
    NANOSECONDS,
    SECONDS,
    MessageError,
    fields,
    get,
    is_list,
)

# Fields that say what the numbers of a message are called, one name for each.
NAMES = ("name", "joint_names", "interface_names", "names")
NO_NUMBERS = ("header", "timestamp", "stamp", "layout")  # of a measurement
_STEPS = re.compile(r"(?:\.|^)(\w+)|\[(\d+)\]")

Named = tuple[tuple[str, ...] | None, list[float]]


@cache
def steps(path: str) -> tuple[str | int, ...]:
    """A path in parts: `points[0].positions` is ("points", 0, "positions").

    Raises:
        ValueError: it is no path.
    """
    found, end = [], 0
    for match in _STEPS.finditer(path):
        if match.start() != end:
            break
        found.append(match[1] if match[2] is None else int(match[2]))
        end = match.end()
    if end != len(path):
        raise ValueError(f"no path of fields: {path!r}; such as pose.position or points[0].x")
    return tuple(found)


def numbers(message: Any, path: str) -> Named:
    """The numbers at a path, and their names where the message itself names them.

    Raises:
        MessageError: there is no such field, it holds something else than numbers, or there are
            not as many numbers as names.
    """
    value, names = _follow(message, path)
    if is_list(value) or isinstance(value, bytes):
        values = [_number(item, path) for item in value]
        if names is not None and len(names) != len(values):
            raise MessageError(f"{path} has {len(values)} values for {len(names)} names")
        return names, values
    if not fields(value):
        return None, [_number(value, path)]
    leaves = list(_leaves(value, ""))
    if not leaves:
        raise MessageError(f"{path or 'the message'} holds no numbers")
    if len(leaves) == 1:
        return None, [leaves[0][1]]
    return tuple(name for name, _ in leaves), [number for _, number in leaves]


def names_at(message: Any, path: str) -> tuple[str, ...] | None:
    """The names that a message gives to the numbers at a path; raises MessageError as `numbers`."""
    return _follow(message, path)[1]


def value_at(message: Any, path: str) -> bool | int | float | str:
    """The one text, number or bool at a path; raises MessageError where there is none."""
    value, _ = _follow(message, path)
    if not isinstance(value, bool | int | float | str):
        raise MessageError(f"{path or 'the message'} is no text, number or bool")
    return value


def number_paths(message: Any, path: str = "") -> Iterator[str]:
    """What of a message can be part of a feature: a path for all numbers that belong together."""
    there = [name for name in fields(message) if name not in NO_NUMBERS]
    if len(there) > 1 and _is_fixed(message):
        yield path
        return
    for name in there:
        value, here = get(message, name), f"{path}.{name}" if path else name
        if is_list(value):
            if len(value) and all(map(_is_number, value)):
                yield here
            elif len(value) and "name" in fields(value[0]):
                yield from (f"{here}.{rest}" for rest in number_paths(value[0]))
            elif len(value) and fields(value[0]):
                yield from number_paths(value[0], f"{here}[0]")
        elif _is_number(value):
            yield here
        elif not _is_time(value):
            yield from number_paths(value, here)


def _is_fixed(message: Any) -> bool:
    """Whether a message is made of numbers alone, as many in each."""
    values = [get(message, name) for name in fields(message) if name not in NO_NUMBERS]
    return all(_is_number(v) or (fields(v) and not _is_time(v) and _is_fixed(v)) for v in values)


def _is_time(value: Any) -> bool:
    return bool(there := set(fields(value))) and there <= {*SECONDS, *NANOSECONDS}


def _follow(message: Any, path: str) -> tuple[Any, tuple[str, ...] | None]:
    """The value at a path, and the names of its items that stand nearest on the way to it."""
    value: Any = message
    names: tuple[str, ...] | None = None
    for step in steps(path):
        if isinstance(step, int):
            if not (is_list(value) or isinstance(value, bytes)) or step >= len(value):
                size = f"{len(value)} items" if is_list(value) else "no list"
                raise MessageError(f"{path}: [{step}] of {size}")
            value = value[step]
        elif is_list(value):
            names = _texts([get(item, "name") for item in value if "name" in fields(item)])
            value = [get(item, step) for item in value]
        else:
            there = fields(value)
            own = (_texts(get(value, name)) for name in NAMES if name in there and name != step)
            names = next((found for found in own if found), names)
            value = get(value, step)
    return value, names


def _texts(value: Any) -> tuple[str, ...] | None:
    if is_list(value) and len(value) and all(isinstance(item, str) for item in value):
        return tuple(value)
    return None


def _leaves(value: Any, path: str) -> Iterator[tuple[str, float]]:
    if _is_number(value):
        yield path, float(value)
    elif is_list(value):
        yield from chain.from_iterable(_leaves(v, f"{path}[{i}]") for i, v in enumerate(value))
    else:
        for name in fields(value):
            if name not in NO_NUMBERS and not _is_time(get(value, name)):
                yield from _leaves(get(value, name), f"{path}.{name}" if path else name)


def _is_number(value: Any) -> bool:
    return isinstance(value, bool | int | float)


def _number(value: Any, path: str) -> float:
    if not _is_number(value):
        kind = "a message" if fields(value) else repr(value)[:40]
        raise MessageError(f"{path or 'the message'} holds {kind} where a number is expected")
    return float(value)
