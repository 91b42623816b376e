"""Acting with a recurrent policy, one control step at a time."""

from __future__ import annotations

import numpy as np
import torch

from lfr.skills.resized import resizing
from studies.imitation.recurrent_gmm import Hidden, RecurrentGMM


class RecurrentPolicy:
    """Draws a mode of the mixture in every step and does its mean.

    That is robomimic's low-noise evaluation, whose standard deviation of 1e-4 about the mean is
    left out. The hidden state begins anew with an episode and after every ``network.horizon``
    steps, since training has seen no longer sequences.

    Args:
        size: of the actions of the arm that acts, if it is another than was imitated; it then does
            them joint by joint (`lfr.skills.resized`).
    """

    def __init__(self, network: RecurrentGMM, size: int | None = None) -> None:
        self.network = network
        self._resizing = resizing(network.action_dim, size or network.action_dim)
        self.reset()

    def reset(self, seed: int = 0) -> None:
        """Begin an episode; the draws of its modes depend on ``seed`` alone."""
        self._generator = torch.Generator().manual_seed(seed)
        self._hidden: Hidden | None = None
        self._done = 0  # control steps of this episode

    @torch.inference_mode()
    def act(self, observation: np.ndarray) -> np.ndarray:
        """The next control step's action, (1, A), for an observation (D,)."""
        if self._done % self.network.horizon == 0:
            self._hidden = None
        self._done += 1
        seen = torch.as_tensor(observation, dtype=torch.float32)[None, None]  # (1, 1, D)
        mixture, self._hidden = self.network(seen, self._hidden)
        weights = mixture.logits[0, 0].softmax(-1)
        mode = int(torch.multinomial(weights, 1, generator=self._generator))
        return mixture.means[0, 0, mode][None].double().numpy() @ self._resizing
