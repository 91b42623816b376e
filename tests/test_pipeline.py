"""dvc.yaml against the code: a stage that misses a dependency would not run again when it must."""

import ast
from pathlib import Path

import grimp
import pytest
from dvc.repo import Repo

from lfr.params import read_yaml
from tests import tiny_project
from tests.external import made_up

ROOT = Path(__file__).parent.parent


def files_of(module: str, root: Path) -> set[Path]:
    """A module's file and the ``__init__`` of every package above it, relative to ``root``."""
    parts = module.split(".")
    names = [Path(*parts[:count]) for count in range(1, len(parts) + 1)]
    inits = {name / "__init__.py" for name in names if (root / name / "__init__.py").is_file()}
    file = Path(*parts).with_suffix(".py")
    return inits | ({file} if (root / file).is_file() else set())


def says_something(file: Path) -> bool:
    """Whether a module holds more than its docstring and version."""
    return any(
        not isinstance(node, ast.Expr)
        and not (isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__version__")
        for node in ast.parse(file.read_text()).body
    )


@pytest.fixture(scope="module")
def imports() -> grimp.ImportGraph:
    """What imports what, also inside functions, but not for types alone."""
    return grimp.build_graph("lfr", "pipeline", exclude_type_checking_imports=True, cache_dir=None)


def stages_of(root: Path) -> dict[str, tuple[str, set[Path]]]:
    """Every stage as DVC resolves it: name -> (its module, the paths it depends on)."""
    with Repo(str(root)) as repo:
        found = {}
        for stage in repo.index.stages:
            words = str(stage.cmd).split()
            module = words[words.index("-m") + 1]
            found[stage.name] = (
                module,
                {
                    Path(dep.fs_path).relative_to(root)
                    for dep in stage.deps
                    if Path(dep.fs_path).is_relative_to(root)
                },
            )
    return found


def test_every_stage_depends_on_all_the_code_it_runs(
    imports: grimp.ImportGraph, tmp_path: Path
) -> None:
    theirs = tiny_project.make(tmp_path / "theirs", made_up.params())
    of_theirs = {"external-skills@crane", "external-mapping@plane-puck-park",
                 "open-loop@plane-puck-park", "external-transfer@plane-puck-park-lfr",
                 "external-evaluate@plane-puck-park-lfr"}  # fmt: skip
    found = stages_of(ROOT) | {
        name: stage for name, stage in stages_of(theirs).items() if name in of_theirs
    }
    assert of_theirs < set(found)
    missing = {}
    for name, (module, deps) in found.items():
        closure = {module, *imports.find_upstream_modules(module)}
        files = set().union(*(files_of(found, ROOT) for found in closure))
        uncovered = {
            str(file)
            for file in files
            if says_something(ROOT / file) and not deps & {file, *file.parents}
        }
        if uncovered:
            missing[name] = sorted(uncovered)
    assert not missing


def test_every_stage_has_a_file_of_its_own() -> None:
    stages = read_yaml(ROOT / "dvc.yaml")["stages"].values()
    commands = (stage.get("do", stage)["cmd"].split() for stage in stages)
    run = {words[words.index("-m") + 1].removeprefix("pipeline.") for words in commands}
    files = [file.relative_to(ROOT / "pipeline") for file in (ROOT / "pipeline").rglob("[a-z]*.py")]
    written = {".".join(file.with_suffix("").parts) for file in files}
    assert run == written
