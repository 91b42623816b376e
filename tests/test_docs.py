"""The documents against the code: what they link to, name and show must be there."""

import argparse
import functools
import importlib
import inspect
import re
import shlex
import tomllib
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, get_args, get_type_hints

import pytest

from lfr import cli
from lfr.artifacts import read_json
from lfr.data.episode import FEATURES, IMAGES
from lfr.evaluation.marked import shown
from lfr.evaluation.readme import MARKER, results_block
from lfr.evaluation.records import CHAIN
from lfr.scenarios import transfers
from lfr.tasks import TASKS

ROOT = Path(__file__).parent.parent
DOCUMENTS = [
    *(ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")),
    *sorted((ROOT / "docs").glob("*.md")),
]
FENCE = re.compile(r"^( *)```.*?^\1```$", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(([^)\s]+)\)")
NAME = re.compile(
    r"`((?:lfr|pipeline|studies)\.[a-z]\w*(?:\.\w+)*)`"
)  # lfr.Action is a message's schema
PARAMETER = re.compile(r"`((?:record|pack|skills|mapping|transfer|evaluate|seeds)(?:\.\w+)+)`")
FILE = re.compile(
    r"(?<![\w/])(?:lfr|pipeline|studies|tests|benchmarks|docs)/[\w/]+\.(?:py|json|rbl|md)"
)
PAGES = {
    "browse.md": ("view",),
    "bring-a-dataset.md": ("import", "record", "view"),
    "publish.md": ("publish", "card"),
    "trust.md": ("verify", "replay", "recover", "diff"),
}
OTHERS = {"--push-to-hub"}  # of a command of LeRobot that `lfr import` prints

documents = pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)


@functools.cache
def anchors(document: Path) -> set[str]:
    """GitHub's anchors of a document's headings."""
    headings = re.findall(r"^#+ (.+)$", FENCE.sub("", document.read_text()), re.MULTILINE)
    words = (re.sub(r"[^\w\- ]", "", heading.lower()) for heading in headings)
    return {each.replace(" ", "-") for each in words}


def commands(start: str) -> list[str]:
    """The lines of all documents' indented blocks that start so."""
    lines = (line for document in DOCUMENTS for line in lines_to_run(document.read_text()))
    return [line for line in lines if line.startswith(start)]


def lines_to_run(text: str) -> list[str]:
    """Commands in indented blocks, without their remarks."""
    lines = re.findall(r"^(?: {4}|\t)+(\S.*)$", FENCE.sub("", text), re.MULTILINE)
    return [line.split("  #")[0].strip() for line in lines]


@documents
def test_relative_links_resolve(document: Path) -> None:
    for link in LINK.findall(FENCE.sub("", document.read_text())):
        if "://" in link:
            continue
        path, _, anchor = link.partition("#")
        target = (document.parent / path).resolve() if path else document
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


@documents
def test_every_name_of_the_code_is_there(document: Path) -> None:
    for name in sorted(set(NAME.findall(document.read_text()))):
        assert found(name), f"{document.name} speaks of {name}"


def found(name: str) -> bool:
    """Whether a dotted name is a module, or an attribute of one, fields of dataclasses included."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            value: Any = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError as error:
            if not ".".join(parts).startswith(str(error.name)):
                raise
            continue
        for part in parts[count:]:
            annotated = part in getattr(value, "__annotations__", {})
            if not annotated and not hasattr(value, part):
                return False
            value = getattr(value, part, None)
        return True
    return False


def test_a_name_that_is_not_there_is_noticed() -> None:
    assert found("lfr.robots.Robot.distal_bodies")
    assert found("lfr.sim.scene")
    assert not found("lfr.robots.Robot.colour")
    assert not found("lfr.no_such_room.thing")


@documents
def test_every_parameter_is_one_of_its_stage(document: Path) -> None:
    from lfr.demos.recorder import RecordParams
    from lfr.evaluation.protocol import EvaluateParams
    from lfr.mapping.mapping_params import MappingParams
    from lfr.skills.skill_params import SkillsParams
    from lfr.transfer.transfer_params import TransferParams
    from pipeline._stage import SeedParams
    from pipeline.pack import PackParams

    sections = {
        "record": RecordParams, "pack": PackParams, "skills": SkillsParams,
        "mapping": MappingParams, "transfer": TransferParams, "evaluate": EvaluateParams,
        "seeds": SeedParams,
    }  # fmt: skip
    for name in PARAMETER.findall(document.read_text()):
        section, *path = name.split(".")
        owner: Any = sections[section]
        for part in path:
            assert part in {field.name for field in fields(owner)}, f"{document.name}: {name}"
            hint = get_type_hints(owner)[part]
            owner = next((each for each in (hint, *get_args(hint)) if is_dataclass(each)), hint)


@documents
def test_commands_name_what_there_is(document: Path) -> None:
    text = document.read_text()
    targets = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    assert set(re.findall(r"\bmake ([\w-]+)", "\n".join(re.findall(r"`.+?`", text)))) <= targets
    for line in lines_to_run(text):
        if line.startswith("make "):
            assert line.split()[1] in targets
    for module in re.findall(r"python -m ((?:lfr|pipeline|studies|benchmarks)\.[\w.]*\w)", text):
        place = ROOT / module.replace(".", "/")
        assert place.with_suffix(".py").is_file() or (place / "__main__.py").is_file(), module
    for path in FILE.findall(text):
        assert (ROOT / path).is_file(), path


def test_commands_parse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of `lfr` in indented blocks, every subcommand among them."""
    seen: list[Any] = []
    for _, module in cli.COMMANDS.values():
        monkeypatch.setattr(importlib.import_module(module), "run", seen.append)
    lines = commands("lfr ")
    for line in lines:
        assert cli.main(shlex.split(line)[1:]) == 0, line
    assert len(seen) == len(lines)
    assert {line.split()[1] for line in lines} == set(cli.COMMANDS)


def test_dvc_commands_parse() -> None:
    from dvc.cli import parse_args

    lines = commands("dvc ")
    assert len(lines) > 10
    for line in lines:
        parse_args(shlex.split(line)[1:])  # raises


def test_stages_are_called_by_their_keys() -> None:
    text = "\n".join(document.read_text() for document in DOCUMENTS)
    called = re.findall(r"python -m (pipeline(?:\.[a-z]\w*)+)(?![\w.])((?: --\w+ \w+)*)", text)
    assert called
    for module, keys in called:
        parameters = inspect.signature(importlib.import_module(module).main).parameters
        assert re.findall(r"--(\w+)", keys) in ([], list(parameters)), (module, keys)


@pytest.mark.parametrize(("page", "names"), PAGES.items())
def test_options_in_the_text_are_there(page: str, names: tuple[str, ...]) -> None:
    text = FENCE.sub("", (ROOT / "docs" / page).read_text())
    spans = [span for span in re.findall(r"`([^`\n]+)`", text) if span.startswith(("--", "lfr "))]
    named = set(re.findall(r"(?<!\S)--[a-z][a-z-]*", " ".join(spans))) - OTHERS
    assert named
    assert sorted(named - options_of(names)) == []


def options_of(names: tuple[str, ...]) -> set[str]:
    """The options of subcommands of `lfr`, as their help says them."""
    found = set()
    for name in names:
        parser = argparse.ArgumentParser()
        importlib.import_module(cli.COMMANDS[name][1]).add_arguments(parser)
        found |= set(re.findall(r"--[a-z][a-z-]*", parser.format_help()))
    return found


def test_readme_shows_what_the_results_hold() -> None:
    assert shown(ROOT / "README.md", MARKER) == results_block(ROOT / "results"), (
        "run `python -m pipeline.report`"
    )


def test_what_the_whole_main_job_took() -> None:
    took = read_json(ROOT / "results/repro.json")
    said = f"{took['seconds'] / 60:.0f} minutes for {took['stages']} stages"
    assert said in " ".join((ROOT / "docs/results.md").read_text().split())
    assert took["at_once"] == 2  # "two at a time"


def test_every_transfer_is_named() -> None:
    text = (ROOT / "docs/start.md").read_text()
    assert [name for name in transfers(ROOT / "params.yaml") if f"`{name}`" not in text] == []


def test_data_names_every_feature_topic_and_group() -> None:
    from lfr.data import messages
    from lfr.spaces import ROBOT_STATE

    text = (ROOT / "docs" / "data.md").read_text()
    topics = [
        value for name, value in vars(messages).items()
        if name.isupper() and isinstance(value, str) and value.startswith("/")
    ]  # fmt: skip
    groups = {each.name for task in TASKS.values() for each in task.environment.quantities}
    state = {name.split(".")[0] for name in ROBOT_STATE.names}
    needed = {*(f.key for f in FEATURES), IMAGES, *topics, *groups, *state, *TASKS}
    assert len(topics) > 5
    assert sorted(name for name in needed if name not in text) == []


def test_method_names_every_link_of_the_chain() -> None:
    text = (ROOT / "docs" / "method.md").read_text()
    assert [link for link in CHAIN if f"`{link}`" not in text] == []


def test_trust_names_every_kind_of_finding() -> None:
    from lfr.curation.verify import CHECKS
    from tests.curation.broken import BROKEN
    from tests.curation.test_behaviour import FAULTS, PICTURES

    text = (ROOT / "docs" / "trust.md").read_text()
    kinds = {check for _, check, _, _ in BROKEN.values()} | {"averaged-quantiles", "format"}
    kinds |= {check for _, check, _ in (*FAULTS.values(), *PICTURES.values())}
    assert len(CHECKS) <= len(kinds)
    assert [kind for kind in sorted(kinds) if f"`{kind}`" not in text] == []


def test_the_drawing_of_rooms_is_the_contract_that_is_checked() -> None:
    contract = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    layers = next(one["layers"] for one in contract["contracts"] if one["containers"] == ["lfr"])
    text = (ROOT / "docs" / "architecture.md").read_text()
    drawing = text.partition("    errors\n")[2].partition("    pipeline, studies")[0]
    drawn = [line.strip().split("   ")[0] for line in drawing.strip().splitlines()]
    found, expected = (
        [sorted(layer.split(" | ")) for layer in given]
        for given in (["errors", *drawn], reversed(layers))
    )
    assert found == expected
