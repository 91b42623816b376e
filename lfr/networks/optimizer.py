"""Adam over one flat vector, so that a step, and Polyak averaging, are a single operation."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn


def trainable(module: nn.Module) -> list[nn.Parameter]:
    return [p for p in module.parameters() if p.requires_grad]


def flatten_parameters(module: nn.Module) -> Tensor:
    """Move a module's trainable parameters into one vector (P,), of which they become views.

    What is done to the vector is done to them; ``load_state_dict`` still works, since it copies
    into the views.
    """
    chosen = trainable(module)
    flat = torch.cat([p.detach().reshape(-1) for p in chosen])
    for parameter, part in zip(chosen, flat.split([p.numel() for p in chosen]), strict=True):
        parameter.data = part.view_as(parameter)
    return flat


fused_adamw = torch.ops.aten._fused_adamw_.default


class FlatAdam:
    """Adam (Kingma and Ba 2014, Algorithm 1) on one vector of parameters; AdamW with a decay.

    torch.optim's own fused kernel, called directly: on a single vector it is one pass over the
    memory, and torch.optim's first step would import torch's compiler, 10 s in every job.

    Attributes:
        flat: the parameters (P,), changed in place.
        lr: may be changed between steps.
    """

    def __init__(
        self,
        flat: Tensor,
        lr: float,
        betas: tuple[float, float] = (0.9, 0.999),
        epsilon: float = 1e-8,
        weight_decay: float = 0.0,
    ) -> None:
        self.lr, self.betas, self.epsilon, self.decay = lr, betas, epsilon, weight_decay
        self.flat = flat
        self.mean = torch.zeros_like(flat)  # m, first moment of the gradient
        self.square = torch.zeros_like(flat)  # v, second moment
        self.count = torch.zeros((), device=flat.device)  # steps, as the kernel takes them

    @torch.no_grad()
    def descend(self, gradient: Tensor) -> None:
        """One step down a gradient (P,)."""
        fused_adamw(
            [self.flat], [gradient], [self.mean], [self.square], [], [self.count.add_(1.0)],
            lr=self.lr, beta1=self.betas[0], beta2=self.betas[1], weight_decay=self.decay,
            eps=self.epsilon, amsgrad=False, maximize=False,
        )  # fmt: skip

    def state(self) -> dict[str, Tensor]:
        """The parameters and both moments, (P,) each, and the number of steps."""
        names = ("flat", "mean", "square", "count")
        return {name: getattr(self, name).clone() for name in names}

    def load_state(self, state: dict[str, Tensor]) -> None:
        for name, value in state.items():
            getattr(self, name).copy_(value)


def annealed(learning_rate: float, step: int, steps: int) -> float:
    """The rate of a step, 0 to ``steps`` - 1, on half a cosine from the first down to zero."""
    return 0.5 * learning_rate * (1.0 + math.cos(math.pi * step / max(steps, 1)))


def clip_norm(gradient: Tensor, limit: float) -> Tensor:
    """A gradient (P,), scaled in place so that its norm is at most ``limit``."""
    norm = float(torch.linalg.vector_norm(gradient))
    return gradient.mul_(limit / norm) if norm > limit else gradient
