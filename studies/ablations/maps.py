"""Other phi for the pairs that Algorithm 1 sees: each a folder ``g``, as the mapping's own."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import torch

from lfr.artifacts import fingerprint
from lfr.mapping.closed_form import constant
from lfr.mapping.generator import Generator
from lfr.mapping.map_quality import decoded_difference, l1
from lfr.mapping.mapping_jobs import MappingJob, Material, read_material
from lfr.mapping.mapping_training import (
    CommonTask,
    Pairs,
    condition_of,
    drawn_pairs,
    paired,
    train_mapping,
)
from lfr.mapping.saved_generators import MappingSeen, save_generator
from lfr.skills.library import RoleModels
from lfr.skills.saved_models import load_vae
from lfr.skills.vae import SkillVAE
from studies.ablations.between_seeds import material_between

MapKind = Literal["trained", "constant", "shuffled"]


@dataclass(frozen=True)
class MapJob:
    """A phi to fit.

    Attributes:
        kind: "trained" is Algorithm 1 itself, with whatever is special about ``mapping``.
        mapping: transfer, parameters and folders; ``g`` comes into its folder.
        other_skills: the source's models of another repetition, to be mapped onto in the target's
            place; None maps from arm to arm.
    """

    kind: MapKind
    mapping: MappingJob
    other_skills: RoleModels | None = None


def map_jobs(mapping: MappingJob, other_skills: RoleModels, folder: Path) -> dict[str, MapJob]:
    """Every other phi of a transfer, by the name of its folder in ``folder``.

    - constant: closed form (`lfr.mapping.closed_form`; the chain has the linear one);
    - untrained: G's random weights between the fitted scales;
    - shuffled: Algorithm 1 on pairs of which it is lost who belongs to whom;
    - no_cycle: Algorithm 1 with lambda = 0;
    - only_<task>: Algorithm 1 on one common task, both VAEs staying those of all tasks;
    - between_seeds: Algorithm 1 between two VAEs of the source (`studies.ablations.between_seeds`).

    Args:
        mapping: the job of the method's own G.
        other_skills: the source's skill models of another repetition.
    """
    params, transfer = mapping.params, mapping.transfer
    alone = {
        f"only_{task}": replace(mapping, transfer=replace(transfer, common=(task,)))
        for task in transfer.common
    }
    trained = {
        "untrained": replace(mapping, params=replace(params, steps=0)),
        "no_cycle": replace(mapping, params=replace(params, cycle_weight=0.0)),
        **alone,
    }
    jobs = {
        "constant": MapJob("constant", mapping),
        "shuffled": MapJob("shuffled", mapping),
        "between_seeds": MapJob("trained", mapping, other_skills),
        **{name: MapJob("trained", job) for name, job in trained.items()},
    }
    return {
        name: replace(job, mapping=replace(job.mapping, folder=str(folder / name)))
        for name, job in jobs.items()
    }


def fit_map(job: MapJob) -> dict[str, Any]:
    """Fit and save ``g``; its errors on held-out states of the tasks that it was fitted to."""
    mapping, transfer = job.mapping, job.mapping.transfer
    seed = int(fingerprint(transfer.name, mapping.seed), 16) % 2**31  # G's own
    source, target = mapping.skills["source"], job.other_skills or mapping.skills["target"]
    if job.other_skills is not None:
        known, vaes = material_between(mapping, job.other_skills, seed)
    else:
        known, vaes = read_material(mapping, seed), (load_vae(source.vae()), load_vae(target.vae()))
    g = fitted(job, known, vaes, seed)
    seen = MappingSeen(
        transfer.name, source.robot, target.robot, (source.name, target.name),
        transfer.common, known.datasets, seed,
    )  # fmt: skip
    save_generator(Path(mapping.folder) / "g", g, seen)
    return {
        "common": {task: map_report(one, g) for task, one in known.held_out.items()},
        "new": {transfer.task: _decoded(known, g, vaes)},
    }


def fitted(job: MapJob, known: Material, vaes: tuple[SkillVAE, SkillVAE], seed: int) -> Generator:
    """The phi of a job."""
    tasks, params = list(known.training.values()), job.mapping.params
    pairs = drawn_pairs(tasks, vaes, known.windows, params, seed)
    if job.kind == "shuffled":
        pairs = shuffled(pairs, seed)
    if job.kind in ("trained", "shuffled"):
        return train_mapping(pairs, params, seed, condition_of(tasks, params))[0]
    return constant(pairs)


def shuffled(pairs: Pairs, seed: int) -> Pairs:
    """Pairs that carry no information: which k_y belongs to which k_x is lost, its task too."""
    order = torch.randperm(len(pairs.k_y), generator=torch.Generator().manual_seed(seed))
    return pairs._replace(k_y=pairs.k_y[order])


@torch.no_grad()
def map_report(task: CommonTask, g: Generator) -> dict[str, float]:
    """G's term of Eq. 5 at a common task's states, and what ignoring its input would reach."""
    k_x, k_y, _ = paired(task, task.observations)
    return {
        "regression_g": l1(g.translate(k_x, g.features(task.observations)), k_y),
        "spread_y": l1(k_y.median(0).values.expand_as(k_y), k_y),
    }


def _decoded(
    known: Material, g: Generator, vaes: tuple[SkillVAE, SkillVAE]
) -> dict[str, dict[str, float]]:
    if known.action_names is None:
        return {}
    rms = decoded_difference(*known.new, g, *vaes).tolist()
    return {"decoded_difference": dict(zip(known.action_names, rms, strict=True))}
