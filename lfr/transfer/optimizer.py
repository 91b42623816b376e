"""Adam over one flat vector, so that a step, and Polyak averaging, are a handful of operations."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn


def flatten_parameters(module: nn.Module, *, trainable: bool = True) -> Tensor:
    """Move a module's parameters into one vector (P,), of which they become views.

    Only those that require a gradient, if ``trainable``. What is done to the vector is done to
    them; ``load_state_dict`` still works, since it copies into the views.
    """
    chosen = [p for p in module.parameters() if p.requires_grad or not trainable]
    flat = torch.cat([p.detach().reshape(-1) for p in chosen])
    parts = flat.split([p.numel() for p in chosen])
    for parameter, part in zip(chosen, parts, strict=True):
        parameter.data = part.view_as(parameter)
    return flat


class FlatAdam:
    """Adam (Kingma and Ba 2014, Algorithm 1) on a module's trainable parameters, as one vector.

    torch.optim costs a Python call per layer and step, more than the arithmetic at these sizes
    (benchmarks/learner.py), and its first step imports torch's compiler, 10 s in every job.

    Attributes:
        flat: the parameters (P,); the module's are views into it.
    """

    def __init__(
        self,
        module: nn.Module,
        lr: float,
        betas: tuple[float, float] = (0.9, 0.999),
        epsilon: float = 1e-8,
    ) -> None:
        self.lr, self.betas, self.epsilon = lr, betas, epsilon
        self.parameters = [p for p in module.parameters() if p.requires_grad]
        self.flat = flatten_parameters(module)
        self.mean = torch.zeros_like(self.flat)  # m, first moment of the gradient
        self.square = torch.zeros_like(self.flat)  # v, second moment
        self.scratch = torch.empty_like(self.flat)
        self.steps = 0

    def step(self, loss: Tensor) -> None:
        """One step down ``loss``; no gradient is left behind on the module's parameters."""
        gradients = torch.autograd.grad(loss, self.parameters)
        self.descend(torch.cat([g.reshape(-1) for g in gradients]))

    @torch.no_grad()
    def descend(self, gradient: Tensor) -> None:
        """One step down a gradient (P,)."""
        (beta1, beta2), self.steps = self.betas, self.steps + 1
        self.mean.lerp_(gradient, 1.0 - beta1)
        self.square.mul_(beta2).addcmul_(gradient, gradient, value=1.0 - beta2)
        # Both bias corrections go into the scalars, which saves a pass over the parameters.
        scale = math.sqrt(1.0 - beta2**self.steps)
        size = self.lr * scale / (1.0 - beta1**self.steps)
        torch.sqrt(self.square, out=self.scratch).add_(self.epsilon * scale)
        self.flat.addcdiv_(self.mean, self.scratch, value=-size)

    def state(self) -> dict[str, Tensor]:
        """The parameters and both moments, (P,) each, and the number of steps."""
        state = {"flat": self.flat, "mean": self.mean, "square": self.square}
        return {k: v.clone() for k, v in state.items()} | {"steps": torch.tensor(self.steps)}

    def load_state(self, state: dict[str, Tensor]) -> None:
        for name in ("flat", "mean", "square"):
            getattr(self, name).copy_(state[name])
        self.steps = int(state["steps"])
