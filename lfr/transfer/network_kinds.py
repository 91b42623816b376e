"""The kinds of network that an actor may consist of, by the names of their classes.

A saved policy names the class of each of its networks. Whoever has a network of a class that is not
here makes it known by `register`, in every process that saves or loads a policy with it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lfr.errors import DataError
from lfr.mapping.saved_generators import GENERATOR
from lfr.model_files import ModelKind
from lfr.skills.resized import RESIZED_VAE
from lfr.skills.saved_models import PRIOR, VAE
from lfr.transfer.actor import OneAction
from lfr.transfer.extended_policy import IdentityMap, StandardNormal

_KINDS: dict[str, ModelKind[Any]] = {}


def register(*kinds: ModelKind[Any]) -> None:
    """Make networks of these kinds known in this process; a second time changes nothing.

    Raises:
        ValueError: another kind has a class of the same name.
    """
    for kind in kinds:
        name = kind.network.__name__
        if _KINDS.setdefault(name, kind) != kind:
            raise ValueError(f"there is another kind of network called {name}")


def network_kind(name: str, file: Path) -> ModelKind[Any]:
    """The kind of the networks whose class is called ``name``.

    Args:
        file: where the name stands, for the message.

    Raises:
        DataError: it is none of those known.
    """
    if name not in _KINDS:
        raise DataError(
            "an unknown kind of network", file=file, found=name, expected=" or ".join(_KINDS)
        )
    return _KINDS[name]


register(
    PRIOR,
    GENERATOR,
    VAE,
    RESIZED_VAE,
    ModelKind("identity_map", IdentityMap, ()),
    ModelKind("standard_normal", StandardNormal, ("latent_dim",)),
    ModelKind("one_action", OneAction, ("latent_dim",)),
)
