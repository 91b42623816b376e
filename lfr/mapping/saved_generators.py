"""G and F on disk, with what they have seen."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from lfr.mapping.generator import Generator
from lfr.model_files import ModelKind, load_seen_as

GENERATOR = ModelKind(
    "generator", Generator, ("latent_dim", "hidden", "layers", "state_names", "turned")
)


@dataclass(frozen=True)
class MappingSeen:
    """What G and F have learned from.

    Attributes:
        transfer: its name.
        source, target: the two embodiments, or external arms; G leads from the source's latent
            space to the target's.
        skills: of either arm's skill models, ``<robot>/<tasks>`` (`lfr.skills.library`): whose
            latent spaces these are.
        tasks: the common tasks.
        datasets: dataset name -> SHA-256 of its rows, of both arms; with L_hand of the source's new
            task too.
        seed: of the training.
    """

    transfer: str
    source: str
    target: str
    skills: tuple[str, str]
    tasks: tuple[str, ...]
    datasets: dict[str, str]
    seed: int


def save_generator(folder: Path, generator: Generator, seen: MappingSeen) -> None:
    GENERATOR.save(folder, generator, seen)


def load_generator(folder: Path) -> Generator:
    """G or F in a folder, ready to translate.

    Raises:
        DataError: the folder holds no generator, or a damaged one.
    """
    return GENERATOR.load(folder)


def load_mapping_seen(folder: Path) -> MappingSeen:
    """What the generator in a folder has learned from."""
    return load_seen_as(MappingSeen, folder, GENERATOR)
