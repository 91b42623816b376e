"""Seeds of episodes: demonstrations only, so that no policy is judged on a start it has seen."""

from __future__ import annotations

from collections.abc import Iterator

from lfr.curation.contents import EPISODES, Contents
from lfr.curation.finding import Finding
from lfr.errors import LfrError
from lfr.seeds import FIRST, PER_USE, use_of_seed

OURS = {"seed", "robot", "task_name"}  # a seed alone may be any project's
EXPECTED = f"a demonstration's: {FIRST['demonstration']} to {FIRST['demonstration'] + PER_USE - 1}"


def check_seeds(contents: Contents) -> Iterator[Finding]:
    """Every episode's seed is a demonstration's, and no start is there twice."""
    if not set(contents.episodes.column_names) >= OURS:
        return
    columns = (contents.episodes[name].to_pylist() for name in ("seed", "robot", "task_name"))
    seen: dict[tuple[int, str, str], int] = {}
    for episode, start in enumerate(zip(*columns, strict=True)):
        seed = start[0]
        if seed is None:
            continue
        try:
            use = use_of_seed(seed)
        except LfrError:
            use = "no"
        if use != "demonstration":
            yield Finding("leaked-seed", f"a seed of {use} episodes", file=EPISODES,
                          episode=episode, column="seed", found=seed,
                          expected=EXPECTED)  # fmt: skip
        if seen.setdefault(start, episode) != episode:
            yield Finding("repeated-seed", "the same start as another episode's", "warning",
                          EPISODES, episode, "seed", found=seed,
                          expected=f"another than episode {seen[start]}'s")  # fmt: skip
