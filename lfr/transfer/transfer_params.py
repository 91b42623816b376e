"""Parameters of transfer learning: the section ``transfer`` of params.yaml.

The paper's part V.A states batch 64, Adam at 1e-3 and a discount of 0.99; where another value is
the default, the comment says why. What the paper leaves open is named as such.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lfr.errors import ParameterError
from lfr.networks.device import DeviceName


@dataclass(frozen=True)
class TransferParams:
    """How a transferred policy is improved on the target arm (Algorithm 2)."""

    steps: int = 40_000  # environment (control) steps, warm-up included
    reward: Literal["sparse", "dense"] = "sparse"
    dense_scale: float = 0.02  # of a skill's summed dense reward; at 0.1 critics outweigh the prior
    train_phi: bool = True  # the paper trains the extended policy; False keeps Eq. 7's phi fixed

    batch: int = 64  # paper; SAC's 256 costs three times as much an update
    policy_lr: float = 3e-4  # paper 1e-3; the policy is pretrained here, SAC's rate keeps it
    critic_lr: float = 1e-3  # paper
    gamma: float = 0.99  # paper; per skill, as in SPiRL, not per control step
    tau: float = 5e-3  # SPiRL; Polyak averaging of the target critics
    updates_per_skill: float = 3.0  # SPiRL 1; a skill's H control steps cost more than an update
    policy_every: int = 2  # updates of the critics to one of the policy (TD3; RLPD and REDQ: 20)
    warm_up: int = 6_000  # environment steps in which the policy stays phi(p_a); critics learn
    replay: int = 100_000  # skills

    critics: int = 2
    critic_hidden: tuple[int, ...] = (256, 256)
    layer_norm: bool = True  # RLPD (Ball et al. 2023): bounds what critics say off the data
    target_subset: int = 0  # REDQ's random subset in the target; 0: the minimum over all critics

    target_divergence: float = 1.5  # nats, summed over the latent; SPiRL 1 (maze) to 5 (kitchen)
    divergence_limit: float = 15.0  # nats; a state's KL beyond it counts by its log; 0: no limit
    min_sigma: float = 0.0  # added in quadrature to sigma of policy and prior
    initial_alpha: float = 0.1
    alpha_lr: float = 1e-3
    fixed_alpha: bool = False  # True: alpha stays at initial_alpha, no dual descent

    simulations: int = 4  # stepped side by side, so that one decode serves all of them
    evaluate_every: int = 5_000  # environment steps
    evaluation_episodes: int = 20  # on learning seeds, never on held-out ones
    checkpoint_every: int = 10_000  # environment steps
    device: DeviceName = "cpu"

    def __post_init__(self) -> None:
        positive = (
            "steps", "policy_every", "dense_scale", "batch", "policy_lr", "critic_lr", "replay",
            "critics", "initial_alpha", "alpha_lr", "simulations", "evaluate_every",
            "evaluation_episodes", "checkpoint_every",
        )  # fmt: skip
        for name in positive:
            if getattr(self, name) <= 0:
                raise ParameterError(f"{name} must be positive, found {getattr(self, name)}")
        not_negative = (
            "updates_per_skill", "warm_up", "target_divergence", "divergence_limit", "min_sigma",
            "target_subset",
        )  # fmt: skip
        for name in not_negative:
            if getattr(self, name) < 0:
                raise ParameterError(f"{name} must not be negative, found {getattr(self, name)}")
        for name in ("gamma", "tau"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ParameterError(f"{name} must lie in [0, 1], found {getattr(self, name)}")
        if self.target_subset > self.critics:
            raise ParameterError(
                f"target_subset must be at most critics = {self.critics}, "
                f"found {self.target_subset}"
            )
        if self.replay < self.batch:
            raise ParameterError(f"replay must hold a batch of {self.batch}, found {self.replay}")
