"""A demonstration as skills: where each of its windows lies, what the priors say, what G makes.

A window is the H actions from a frame on. The skill VAE of the demonstration's own arm gives its
posterior q(z|a); the source's prior p(z|s) predicts a skill from the same frame's observation, in
the source's latent space; G translates that prediction into the target's (Eq. 4). Where the target
has a prior of the task too, it stands beside the translation, which is what the mapping learns from
(Algorithm 1).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lfr.data.episode import ACTION, ENVIRONMENT_STATE, STATE, Episode
from lfr.errors import DataError, LfrError, UnknownNameError

if TYPE_CHECKING:
    from torch import Tensor

    from lfr.mapping.generator import Generator
    from lfr.skills.library import SkillFolder
    from lfr.skills.prior import SkillPrior
    from lfr.skills.vae import SkillVAE

Arm = Literal["source", "target"]


class Gaussians(NamedTuple):
    """K diagonal Gaussians over a latent space: mean and log sigma, (K, Z) each."""

    mu: NDArray[np.float64]
    log_sigma: NDArray[np.float64]


@dataclass(frozen=True)
class SkillModels:
    """The models of one transfer that say something of a task's demonstrations.

    Attributes:
        name: of the transfer.
        robots: the source's and the target's embodiment.
        actions: the names of the dimensions of either's actions.
        vaes: the skill VAE of either.
        source_prior: p(z|s) of the task, in the source's latent space.
        target_prior: the target's own, where it has seen the task.
        generator: G, from the source's latent space to the target's.
    """

    name: str
    robots: dict[Arm, str]
    actions: dict[Arm, tuple[str, ...]]
    vaes: dict[Arm, SkillVAE]
    source_prior: SkillPrior
    target_prior: SkillPrior | None
    generator: Generator

    def arm_of(self, robot: str) -> Arm:
        """Which of the two arms a robot is.

        Raises:
            UnknownNameError: neither.
        """
        for arm, name in self.robots.items():
            if name == robot:
                return arm
        raise UnknownNameError(f"robot of {self.name}", robot, self.robots.values())


@dataclass(frozen=True)
class WindowTrace:
    """The K windows of a demonstration, one at each frame from which H actions are left.

    Attributes:
        arm: whose demonstration it is: `window` lies in that arm's latent space.
        window: q(z|a) of each window.
        prior: p(z|s) of the source, in the source's latent space.
        mapped: G(p(z|s)), in the target's.
        mapped_window: G(q(z|a)) of a source's demonstration, in the target's; else None.
        target_prior: the target's own p(z|s), in the target's; None where it has none.
        decoded: what the means decode to, by what was decoded, (K, H, A); without that of an arm
            whose actions are not of the demonstration's kind.
    """

    arm: Arm
    window: Gaussians
    prior: Gaussians
    mapped: Gaussians
    mapped_window: Gaussians | None
    target_prior: Gaussians | None
    decoded: dict[str, NDArray[np.float64]]

    def __len__(self) -> int:
        return len(self.window.mu)

    @property
    def latent_dim(self) -> int:
        return self.window.mu.shape[1]


def load_skill_models(mapping: Path, task: str, skills: Path | None = None) -> SkillModels:
    """The G of a transfer, and the skill models that it leads from and to.

    Args:
        mapping: `models/mapping/<transfer>`.
        task: of the demonstrations.
        skills: the folder of all skill models; by default those beside the folder of all mappings.

    Raises:
        DataError: a model is missing or damaged.
        LfrError: the source has no prior of the task.
    """
    from lfr.mapping.saved_generators import load_generator, load_mapping_seen
    from lfr.skills.saved_models import load_prior, load_seen, load_vae

    if not (mapping / "g").is_dir():
        raise DataError("no mapping", file=mapping, expected="models/mapping/<transfer>")
    seen = load_mapping_seen(mapping / "g")
    models = mapping.resolve().parent.parent
    roots = [models / "skills", models / "external-skills"] if skills is None else [skills]
    source, target = (_skill_folder(roots, name) for name in seen.skills)
    prior, own = source.prior(task), target.prior(task)
    if not prior.is_dir():
        known = sorted(p.name.removeprefix("prior-") for p in source.path.glob("prior-*"))
        raise LfrError(f"{mapping}: no prior of {task!r}; the source's are of: {', '.join(known)}")
    folders: dict[Arm, SkillFolder] = {"source": source, "target": target}
    actions: dict[Arm, tuple[str, ...]] = {}
    for arm, folder in folders.items():
        space = load_seen(folder.vae).actions
        actions[arm] = space.names if space else ()
    return SkillModels(
        name=seen.transfer,
        robots={"source": seen.source, "target": seen.target},
        actions=actions,
        vaes={arm: load_vae(folder.vae) for arm, folder in folders.items()},
        source_prior=load_prior(prior),
        target_prior=load_prior(own) if own.is_dir() else None,
        generator=load_generator(mapping / "g"),
    )


def _skill_folder(roots: list[Path], name: str) -> SkillFolder:
    """Where the models ``<robot>/<tasks>`` lie, below one of the folders of all skill models."""
    from lfr.skills.library import SkillFolder

    for root in roots:
        if (root / name).is_dir():
            return SkillFolder(root / name)
    raise DataError("no skill models", file=roots[0] / name)


def trace_windows(models: SkillModels, episode: Episode) -> WindowTrace:
    """What the models make of every window of an episode.

    Raises:
        DataError: an observation of another layout than the priors', or too few frames.
        UnknownNameError: the episode is of neither arm.
    """
    import torch

    arm = models.arm_of(episode.robot)
    vae, source, target = models.vaes[arm], models.vaes["source"], models.vaes["target"]
    observations, actions = _windows(episode, vae.horizon, models.source_prior.layout_names)
    with torch.no_grad():
        window = vae.encode(actions, observations)
        prior = models.source_prior(observations)
        mapped = models.generator.at(prior[0], prior[1], observations)
        mapped_window = (
            models.generator.at(window[0], window[1], observations) if arm == "source" else None
        )
        own = None if models.target_prior is None else models.target_prior(observations)
        decoded = {"window": vae.decode(window[0], observations)}
        if models.actions["source"] == models.actions[arm]:
            decoded["source prior"] = source.decode(prior[0], observations)
        if models.actions["target"] == models.actions[arm]:
            decoded["mapped prior"] = target.decode(mapped[0], observations)
    return WindowTrace(
        arm=arm,
        window=_gaussians(window),
        prior=_gaussians(prior),
        mapped=_gaussians(mapped),
        mapped_window=None if mapped_window is None else _gaussians(mapped_window),
        target_prior=None if own is None else _gaussians(own),
        decoded={name: part.double().numpy() for name, part in decoded.items()},
    )


def divergence(p: Gaussians, q: Gaussians) -> NDArray[np.float64]:
    """(K,) KL(p || q) in nats, summed over the dimensions."""
    import torch

    from lfr.skills.gaussian import kl_divergence

    return kl_divergence(*map(torch.from_numpy, (*p, *q))).numpy()


def action_windows(episode: Episode, horizon: int) -> NDArray[np.float32]:
    """(K, H, A): the H actions from each frame on, as long as there are as many.

    Raises:
        DataError: not one window.
    """
    actions = np.asarray(episode.features[ACTION], np.float32)
    count = len(actions) - horizon + 1
    if count < 1:
        raise DataError("too short for a skill", file=str(episode.metadata.get("file", "episode")),
                        found=f"{len(actions)} frames", expected=f"{horizon}")  # fmt: skip
    return actions[np.arange(count)[:, None] + np.arange(horizon)]


def _windows(episode: Episode, horizon: int, names: tuple[str, ...]) -> tuple[Tensor, Tensor]:
    import torch

    schema = episode.schema
    found = [name for key in (STATE, ENVIRONMENT_STATE) for name in schema[key].names or ()]
    if found != list(names):
        differing = next((n for n in found if n not in names), found[-1] if found else "none")
        raise DataError(
            "another observation than the skill prior's",
            file=str(episode.metadata.get("file", "episode")),
            column=differing, found=f"{len(found)} dimensions", expected=f"{len(names)}",
        )  # fmt: skip
    actions = action_windows(episode, horizon)
    parts = [episode.features[key][: len(actions)] for key in (STATE, ENVIRONMENT_STATE)]
    observations = np.concatenate(parts, axis=1).astype(np.float32)
    return torch.from_numpy(observations), torch.from_numpy(actions)


def _gaussians(pair: tuple[Tensor, Tensor]) -> Gaussians:
    return Gaussians(*(part.double().numpy() for part in pair))
