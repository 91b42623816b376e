"""What `make site` does beyond MkDocs: the README as its first page, what pages show of `results/`,
and a page of reference for each of the library's modules."""

from __future__ import annotations

import ast
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parent.parent
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
SHOWN = (".svg", ".png", ".gif", ".md", ".json", ".csv")
COPIED: set[Path] = set()


def on_files(files: Files, config: Any) -> Files:
    """Add the first page and the reference."""
    files.append(File.generated(config, "index.md", content=(ROOT / "README.md").read_text()))
    listed = ["# Reference", ""]
    for module, path in modules():
        said = ast.get_docstring(ast.parse(source_of(path).read_text())) or ""
        listed.append(f"- [`{module}`]({path}.md): {said.partition(chr(10))[0]}")
        text = f"---\ntitle: {module}\n---\n\n::: {module}\n"
        files.append(File.generated(config, f"reference/{path}.md", content=text))
    files.append(File.generated(config, "reference/index.md", content="\n".join(listed)))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Files) -> str:
    """Links that leave `docs/`: to a copy of a result, or no link where it is code."""
    folder = ROOT if page.file.src_uri == "index.md" else ROOT / "docs"

    def link(found: re.Match[str]) -> str:
        picture, words, target = found.groups()
        path, _, anchor = target.partition("#")
        place = (folder / path).resolve()
        if "://" in target or not path or not place.exists():
            return found.group(0)
        if place.is_relative_to(ROOT / "docs"):
            inside = place.relative_to(ROOT / "docs").as_posix()
            return f"{picture}[{words}]({inside}{'#' + anchor if anchor else ''})"
        if place.suffix in SHOWN and place.is_relative_to(ROOT / "results"):
            COPIED.add(place.relative_to(ROOT))
            return f"{picture}[{words}](files/{place.relative_to(ROOT).as_posix()})"
        return words

    return LINK.sub(link, markdown)


def on_post_build(config: Any) -> None:
    """Copy the results that pages show or link to."""
    for path in COPIED:
        copy = Path(config["site_dir"]) / "files" / path
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / path, copy)


def source_of(path: str) -> Path:
    """The file of a module, by its place."""
    package = ROOT / path / "__init__.py"
    return package if package.is_file() else ROOT / f"{path}.py"


def modules() -> Iterator[tuple[str, str]]:
    """Public modules of the library that say what they are, by name and place."""
    for file in sorted((ROOT / "lfr").rglob("*.py")):
        parts = file.relative_to(ROOT).with_suffix("").parts
        if parts[-1] == "__init__":
            parts = parts[:-1]
        if not any(part.startswith("_") for part in parts):
            yield ".".join(parts), "/".join(parts)
