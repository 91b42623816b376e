"""Which runs of transfer learning params.yaml asks for, checked against what there is."""

from __future__ import annotations

from typing import Literal

from lfr.errors import ParameterError, UnknownNameError
from lfr.params import PARAMS, read_yaml
from lfr.scenarios import transfers
from lfr.transfer.methods import METHODS


def listed(kind: Literal["transfers", "methods"]) -> list[str]:
    """The names under ``transfers`` or ``methods`` of params.yaml, each checked.

    Raises:
        ParameterError: no such list.
        UnknownNameError: a name on it is unknown.
    """
    names = read_yaml(PARAMS).get(kind)
    if not isinstance(names, list) or not names:
        raise ParameterError(f"{PARAMS}: {kind}: found {names!r}, expected a list of names")
    known = METHODS if kind == "methods" else transfers()
    for name in names:
        if name not in known:
            raise UnknownNameError(kind.removesuffix("s"), name, known)
    return names
