"""Parameters of the skills stage: section ``skills`` of params.yaml."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from lfr.errors import ParameterError
from lfr.networks.device import DeviceName
from lfr.skills.hand_motion import JacobianParams
from lfr.skills.symmetry import SymmetryParams


@dataclass(frozen=True)
class VAEParams:
    """The skill VAE: sizes from the paper's part V.A and SPiRL, the rest measured."""

    horizon: int = 10  # H, control steps of a skill
    execute: int = 5  # of them carried out before the next skill is chosen; the paper's is H
    whole_release: bool = True  # but of a skill that opens a hand which holds, all H
    latent_dim: int = 32  # Z; the paper's is 10
    hidden: int = 128  # LSTM units
    alpha: float = 1e-5  # weight of the divergence in Eq. 3
    steps: int = 3000
    batch: int = 64
    learning_rate: float = 8e-3
    augment: float = 0.5  # share of each batch whose windows are turned, scaled, recombined
    condition: Literal["none", "pose"] = "pose"  # what q(z|a) and p(a|z) see: the hand's pose
    error: Literal["actions", "hand"] = "hand"  # where Eq. 2 measures it; of joint motions at
    # the hand too, by the Jacobian of the arm's own demonstrations

    def __post_init__(self) -> None:
        if self.execute < 1:
            raise ParameterError(f"execute must be at least 1, found {self.execute}")


@dataclass(frozen=True)
class PriorParams:
    """The skill prior: six hidden layers of 128, one per robot and task.

    beta of Eq. 3 does not appear: the posterior is frozen in L_task, so the prior's gradients do
    not mix with the VAE's, and Adam is indifferent to the scale.
    """

    hidden: int = 128
    layers: int = 6
    steps: int = 6000
    batch: int = 128
    learning_rate: float = 1e-3
    weight_decay: float = 1e-2
    input_noise: float = 0.2  # of an input's normalised unit, against overfitting 50 episodes
    symmetry: SymmetryParams = field(default_factory=lambda: SymmetryParams(shift=0.2))
    joint_copies: bool = True  # of joint motions too (`lfr.skills.moved_joints`)


@dataclass(frozen=True)
class SkillsParams:
    vae: VAEParams = field(default_factory=VAEParams)
    prior: PriorParams = field(default_factory=PriorParams)
    held_out: float = 0.1  # share of each dataset's episodes kept for the report
    device: DeviceName = "cpu"
    jacobian: JacobianParams = field(default_factory=JacobianParams)
