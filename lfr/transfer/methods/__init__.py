"""The methods that can be trained on the target arm: what each one begins with.

A method is a factory from the models at hand to what a run begins with. A new one is a small file
beside this with such a factory, and a row in ``METHODS``. Methods of one's own that the library
need not know are given where they are asked for, in a mapping of the same form.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import torch

from lfr.artifacts import fingerprint
from lfr.errors import UnknownNameError
from lfr.transfer.methods.adapted import ap, no_generator
from lfr.transfer.methods.initialization import Initialization, TrainedModels
from lfr.transfer.methods.lfr import lfr
from lfr.transfer.methods.sac import sac
from lfr.transfer.transfer_params import TransferParams

Method = Callable[[TrainedModels, TransferParams], Initialization]

METHODS: Mapping[str, Method] = {
    "lfr": lfr,
    "ap": ap,
    "sac": sac,
    "no_generator": no_generator,
}


def method(name: str, methods: Mapping[str, Method] = METHODS) -> Method:
    """The method called ``name``.

    Raises:
        UnknownNameError: there is none.
    """
    if name not in methods:
        raise UnknownNameError("method", name, methods)
    return methods[name]


def initialize(
    name: str,
    models: TrainedModels,
    params: TransferParams,
    seed: int,
    methods: Mapping[str, Method] = METHODS,
) -> Initialization:
    """What a run of the method called ``name`` begins with.

    Args:
        seed: draws the weights of new networks.

    Raises:
        UnknownNameError: there is no such method.
        DataError: it needs a model that is missing or damaged.
    """
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(int(fingerprint("start", seed), 16) % 2**31)  # not the critics' stream
        return method(name, methods)(models, params)
