"""Parameters of the mapping stage: section ``mapping`` of params.yaml."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from lfr.networks.device import DeviceName
from lfr.skills.symmetry import SymmetryParams


@dataclass(frozen=True)
class HandLossParams:
    """What G is held to beside Eq. 4: that the hand moves alike (`lfr.mapping.hand_loss`)."""

    weight: float = 1000.0  # beside L_reg of Eq. 4; 0 is the paper's
    batch: int = 64
    recombined: float = 0.5  # share of the skills that begin in another skill's state


@dataclass(frozen=True)
class MappingParams:
    """G and F: sizes and lambda from the paper's part V.A, the rest measured."""

    hidden: int = 256
    layers: int = 3  # part V.A
    cycle_weight: float = 1.0  # lambda of Eq. 4
    steps: int = 4000
    batch: int = 256
    learning_rate: float = 1e-3
    symmetry: SymmetryParams = field(default_factory=SymmetryParams)  # of the states compared
    state_noise: float = 0.1  # of an input's normalised unit: states between and beside the demos
    posterior_share: float = 0.5  # share of pairs that are both encoders' posteriors of one window
    condition: Literal["none", "state"] = "state"  # what G and F see beside k: G(k), or G(k, s)
    hand: HandLossParams = field(default_factory=HandLossParams)
    device: DeviceName = "cpu"
