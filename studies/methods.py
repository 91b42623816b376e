"""The methods of the ablations: Learn from Robot with one part exchanged, and SPiRL."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from lfr.errors import DataError
from lfr.mapping.saved_generators import load_generator
from lfr.skills.saved_models import load_prior, load_vae
from lfr.tasks import TASKS
from lfr.transfer.extended_policy import IdentityMap, StandardNormal
from lfr.transfer.methods import METHODS, Method
from lfr.transfer.methods.initialization import (
    Initialization,
    TrainedModels,
    initialize_from,
    new_pi,
)
from lfr.transfer.network_kinds import register
from lfr.transfer.transfer_params import TransferParams
from studies.ablations.other_task import OTHER_TASK, load_other_task
from studies.ablations.residual_prior import RESIDUAL_PRIOR, residual_prior


def register_networks() -> None:
    """Make the ablations' networks known, so that policies with them can be saved and loaded."""
    register(OTHER_TASK, RESIDUAL_PRIOR)


def methods(variants: Path) -> Mapping[str, Method]:
    """The library's methods and the ablations', whose networks are known from here on.

    Args:
        variants: folder of what `studies.ablations.variants` has trained for the transfer; asked
            for when a method begins, and by the methods that need it alone.
    """
    register_networks()
    return {
        **METHODS,
        **{f"only_{task}": partial(only, task, variants) for task in TASKS},
        "spirl": partial(spirl, variants),
        "spirl_no_prior": spirl_no_prior,
        "shared_vae": partial(shared_vae, variants),
        "wrong_task": partial(wrong_task, variants),
    }


def only(
    task: str, variants: Path, models: TrainedModels, params: TransferParams
) -> Initialization:
    """Table III: G has learned from one common task alone."""
    prior, g = models.source_prior(), load_generator(_variant(variants, f"only_{task}") / "g")
    return initialize_from(prior, g, models.target_vae(), params, prior)


def shared_vae(variants: Path, models: TrainedModels, params: TransferParams) -> Initialization:
    """One latent space of both arms, so that nothing has to be translated."""
    folder = _variant(variants, "shared_vae")
    prior, vae = load_prior(folder / "prior"), load_vae(folder / "vae")
    return initialize_from(prior, IdentityMap(), vae, params, prior)


def wrong_task(variants: Path, models: TrainedModels, params: TransferParams) -> Initialization:
    """The source's prior of another task, mapped: what is it worth to know the right one?

    What the wrong task has not, the policy that learns sees all the same.
    """
    prior = load_other_task(_variant(variants, "wrong_task") / "prior")
    reference, vae = models.source_prior(), models.target_vae()
    pi = residual_prior(prior, reference)
    return initialize_from(prior, models.generator(), vae, params, reference, pi)


def spirl(variants: Path, models: TrainedModels, params: TransferParams) -> Initialization:
    """SPiRL (Pertsch et al. 2021) on the target alone, from its own prior of its common tasks.

    Nothing comes from the other arm but the units of the critics' inputs, which are the same for
    every method. The prior knows nothing of a goal; the policy that begins with it sees everything.
    """
    prior = load_other_task(_variant(variants, "any_task") / "prior")
    reference, vae = models.source_prior(), models.target_vae()
    pi = residual_prior(prior, reference)
    return initialize_from(prior, IdentityMap(), vae, params, reference, pi)


def spirl_no_prior(models: TrainedModels, params: TransferParams) -> Initialization:
    """Skills without a prior: a new policy over the target's latent space, near N(0, I)."""
    reference, vae = models.source_prior(), models.target_vae()
    pi = new_pi(reference, vae.latent_dim, reference.hidden, reference.layers)
    nothing = StandardNormal(vae.latent_dim)
    return initialize_from(nothing, IdentityMap(), vae, params, reference, pi)


def _variant(variants: Path, name: str) -> Path:
    """Raises DataError where it has not been trained."""
    if not (variants / name).is_dir():
        raise DataError(
            "no models of this ablation; `studies.ablations.variants` trains them",
            file=variants / name,
        )
    return variants / name
