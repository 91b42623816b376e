"""Replay buffer B of Algorithm 2: one preallocated matrix, one row per executed skill."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor


class Batch(NamedTuple):
    """B transitions of Algorithm 2, float32.

    The frozen phi(p_a) at both observations is stored with them: it never changes, so evaluating
    it once as a skill is executed replaces two forward passes in every update.
    """

    observation: Tensor  # (B, D) s_t, in the layout's units
    z: Tensor  # (B, Z) the executed skill
    reward: Tensor  # (B,) summed over the control steps that were executed
    discount: Tensor  # (B,) gamma, or 0 where s_{t+1} is terminal
    next_observation: Tensor  # (B, D) s_{t+1}
    prior_mu: Tensor  # (B, Z) phi(p_a(.|s_t))
    prior_log_sigma: Tensor  # (B, Z)
    next_prior_mu: Tensor  # (B, Z) phi(p_a(.|s_{t+1}))
    next_prior_log_sigma: Tensor  # (B, Z)


class Replay:
    """A ring of ``capacity`` rows; once full, the oldest row is written over.

        rows     0 ............ cursor ......... capacity - 1
                 newest ........^ oldest .......
        columns  | s_t | z | r | discount | s_{t+1} | phi(p_a) at s_t | phi(p_a) at s_{t+1} |

    Because a row holds a whole transition, a batch is one gather and nine views.
    """

    def __init__(self, capacity: int, observation_dim: int, latent_dim: int) -> None:
        d, z = observation_dim, latent_dim
        self.widths = (d, z, 1, 1, d, z, z, z, z)
        self.capacity = capacity
        self.rows = torch.zeros(capacity, sum(self.widths))
        self.cursor = 0
        self.size = 0

    def __len__(self) -> int:
        return self.size

    def add(self, batch: Batch) -> None:
        """Append N transitions, N <= capacity."""
        columns = [c[:, None] if c.dim() == 1 else c for c in batch]
        rows = torch.cat([c.to(self.rows) for c in columns], dim=1)
        places = (self.cursor + torch.arange(len(rows))) % self.capacity
        self.rows[places] = rows
        self.cursor = (self.cursor + len(rows)) % self.capacity
        self.size = min(self.size + len(rows), self.capacity)

    def sample(self, batch: int, generator: torch.Generator) -> Batch:
        """``batch`` transitions drawn uniformly with replacement."""
        places = torch.randint(self.size, (batch,), generator=generator)
        parts = self.rows.index_select(0, places).split(self.widths, dim=1)
        observation, z, reward, discount, *rest = parts
        return Batch(observation, z, reward.squeeze(1), discount.squeeze(1), *rest)

    def state(self) -> dict[str, Tensor]:
        """The filled rows (size, W) and the cursor: all that ``load_state`` needs."""
        return {"rows": self.rows[: self.size].clone(), "cursor": torch.tensor(self.cursor)}

    def load_state(self, state: dict[str, Tensor]) -> None:
        self.size = len(state["rows"])
        self.rows[: self.size] = state["rows"]
        self.cursor = int(state["cursor"])
