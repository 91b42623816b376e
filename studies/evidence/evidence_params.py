"""What the evidence asks: `evidence.yaml`, merged over the main job's parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from lfr.artifacts import as_json
from lfr.demos.recorder import RecordParams
from lfr.errors import UnknownNameError
from lfr.mapping.mapping_params import MappingParams
from lfr.params import read_section, read_yaml
from lfr.records import from_mapping
from lfr.scenarios import Scenario, Transfer, scenarios, transfers_of
from lfr.skills.skill_params import SkillsParams
from lfr.transfer.transfer_params import TransferParams
from studies.imitation.imitation_params import ImitationParams

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

ASKED = Path(__file__).with_name("evidence.yaml")
OURS = "ours"
MATRIX = "matrix"


@dataclass(frozen=True)
class Option:
    """A way to learn G.

    Attributes:
        mapping: what differs from section ``mapping`` of params.yaml.
        common: the common tasks that it learns from; none are all.
    """

    mapping: dict[str, Any] = field(default_factory=dict)
    common: tuple[str, ...] = ()


@dataclass(frozen=True)
class Matrix:
    """Each of ``arms`` teaches each other one ``task``."""

    arms: tuple[str, ...]
    controller: str
    common: tuple[str, ...]
    task: str


@dataclass(frozen=True)
class Setting:
    """Transfers, and what is run on each.

    Attributes:
        transfers: by name, or "matrix".
        seeds: how many repetitions, from 0 on.
        links: whether the chain is measured.
        methods: that learn.
        options: of the mapping, judged before learning.
        learned: those of them that learn too.
        stock: methods whose learned policies stock robosuite judges as well.
        demonstrations: of each arm and task, where it is not the main job's number.
    """

    transfers: tuple[str, ...]
    seeds: int
    links: bool = False
    methods: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    learned: tuple[str, ...] = ()
    stock: tuple[str, ...] = ()
    reward: Literal["sparse", "dense"] = "sparse"
    demonstrations: int | None = None


@dataclass(frozen=True)
class _File:
    """evidence.yaml but for its scenarios."""

    matrix: Matrix
    options: dict[str, Option]
    methods: dict[str, dict[str, Any]]
    imitation: ImitationParams
    episodes: int
    stock_episodes: int
    settings: dict[str, Setting]


@dataclass(frozen=True)
class Asked(_File):
    """All of `evidence.yaml`, with the parameters of params.yaml beneath."""

    record: RecordParams
    skills: SkillsParams
    mapping: MappingParams
    transfer: TransferParams
    scenarios: dict[str, Scenario]

    def transfers(self, setting: Setting) -> list[tuple[Scenario, Transfer]]:
        """Those of a setting.

        Raises:
            UnknownNameError: it names one that there is not.
        """
        known = {
            transfer.name: (scenario, transfer)
            for scenario in self.scenarios.values()
            for transfer in transfers_of(scenario)
        }
        found = []
        for name in setting.transfers:
            if name == MATRIX:
                found += [(one, transfers_of(one)[0]) for one in self._matrix()]
            elif name in known:
                found.append(known[name])
            else:
                raise UnknownNameError("transfer", name, (*known, MATRIX))
        return found

    def all_transfers(self, demonstrations: int | None) -> list[tuple[Scenario, Transfer]]:
        """Those of all settings with so many demonstrations."""
        return [
            one
            for setting in self.settings.values()
            if setting.demonstrations == demonstrations
            for one in self.transfers(setting)
        ]

    def record_params(self, setting: Setting) -> RecordParams:
        """Without pictures, which nothing here looks at."""
        return replace(
            self.record, cameras=(), episodes=setting.demonstrations or self.record.episodes
        )

    def mapping_params(self, option: str) -> MappingParams:
        return merged(self.mapping, self.options[option].mapping, f"options.{option}")

    def transfer_params(self, method: str, reward: str) -> TransferParams:
        changes = {**self.methods.get(method, {}), "reward": reward}
        return merged(self.transfer, changes, f"methods.{method}")

    def _matrix(self) -> list[Scenario]:
        arms = [f"{arm}-{self.matrix.controller}" for arm in self.matrix.arms]
        return [
            Scenario(f"{MATRIX}-{source}", self.matrix.common, {target: self.matrix.task},
                     (target, source))
            for source in arms for target in arms if source != target
        ]  # fmt: skip


def read_asked(path: Path = ASKED) -> Asked:
    """Raises ParameterError where either file is not what it should be."""
    content = read_yaml(path)
    sections = {
        "record": read_section(RecordParams, "record"),
        "skills": read_section(SkillsParams, "skills"),
        "mapping": read_section(MappingParams, "mapping"),
        "transfer": read_section(TransferParams, "transfer"),
        "scenarios": scenarios(path),
    }
    plain = from_mapping(
        _File, {key: value for key, value in content.items() if key != "scenarios"}, str(path)
    )
    asked = Asked(**vars(plain), **sections)
    for setting in asked.settings.values():
        asked.transfers(setting)
        for option in (*setting.options, *setting.learned):
            if option not in asked.options:
                raise UnknownNameError("option", option, asked.options)
    return asked


def merged[Params: DataclassInstance](
    params: Params, changes: Mapping[str, Any], where: str
) -> Params:
    """``params`` with what ``changes`` names, down to any depth.

    Raises:
        ParameterError: it names what there is not.
    """
    return from_mapping(type(params), _merge(as_json(params), changes), where)


def _merge(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    both = {
        name: _merge(below[name], value)
        for name, value in above.items()
        if isinstance(value, Mapping) and isinstance(below.get(name), Mapping)
    }
    return {**below, **above, **both}
