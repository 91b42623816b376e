"""The methods that can be trained on the target arm: what each one starts from.

A method is a factory from the models at hand to what a run needs. A new one is a small file beside
this with such a factory, and a row in ``METHODS``.
"""

from __future__ import annotations

from collections.abc import Callable

import torch

from lfr.artifacts import fingerprint
from lfr.errors import UnknownNameError
from lfr.tasks import TASKS
from lfr.transfer.methods.adapted import ap, no_generator
from lfr.transfer.methods.controls import only, shared_vae, wrong_task
from lfr.transfer.methods.lfr import lfr
from lfr.transfer.methods.sac import sac
from lfr.transfer.methods.spirl import spirl, spirl_no_prior
from lfr.transfer.methods.start import Start, TrainedModels
from lfr.transfer.params import TransferParams

Method = Callable[[TrainedModels, TransferParams], Start]

METHODS: dict[str, Method] = {
    "lfr": lfr,
    "ap": ap,
    "sac": sac,
    "no_generator": no_generator,
    **{f"only_{task}": only(task) for task in TASKS},
    "spirl": spirl,
    "spirl_no_prior": spirl_no_prior,
    "shared_vae": shared_vae,
    "wrong_task": wrong_task,
}

VARIANTS = {
    **{f"only_{task}": f"only_{task}" for task in TASKS},
    "spirl": "any_task",
    "shared_vae": "shared_vae",
    "wrong_task": "wrong_task",
}
"""What a method needs of `lfr.ablations`; those that are not here need nothing of it."""


def method(name: str) -> Method:
    """The method called ``name``.

    Raises:
        UnknownNameError: there is none.
    """
    if name not in METHODS:
        raise UnknownNameError("method", name, METHODS)
    return METHODS[name]


def start_of(name: str, models: TrainedModels, params: TransferParams, seed: int) -> Start:
    """Where a run of the method called ``name`` starts; ``seed`` draws the weights of new networks.

    Raises:
        UnknownNameError: there is no such method.
        DataError: it needs a model that is missing or damaged.
    """
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(int(fingerprint("start", seed), 16) % 2**31)  # not the critics' stream
        return method(name)(models, params)
