"""Where networks are trained: on the processor, or on a CUDA device.

Everything random is drawn on the processor and brought over, so that a seed's training sees the
same numbers on either, and what they give differs by rounding alone. Networks are saved, and act in
trials, on the processor.
"""

from __future__ import annotations

from typing import Literal

import torch

from lfr.errors import ParameterError

DeviceName = Literal["auto", "cpu", "cuda"]

CPU = torch.device("cpu")


def device_named(name: DeviceName) -> torch.device:
    """The device called ``name``; "auto" is CUDA where torch finds one.

    Raises:
        ParameterError: CUDA was asked for, and torch finds none.
    """
    found = name != "cpu" and torch.cuda.is_available()
    if name == "cuda" and not found:
        raise ParameterError("device cuda: torch finds no CUDA device here; choose auto or cpu")
    return torch.device("cuda" if found else "cpu")
