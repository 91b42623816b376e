"""meta/tasks.parquet: the words of each task_index, told from the episodes' lists of tasks."""

from __future__ import annotations

from lfr.curation.checks.counts import task_words
from lfr.curation.contents import TASKS, Contents
from lfr.curation.finding import Unreadable
from lfr.curation.meta_files import write_tasks
from lfr.curation.repair.draft import Draft, Unmendable
from lfr.curation.repair.episode_rows import match, read_episodes
from lfr.curation.repair.rows import episode_lengths


def mend_tasks(draft: Draft) -> None:
    """Write the words anew where they are lost, or where rows have tasks without words.

    Raises:
        Unmendable: the episodes' lists do not tell which words are whose.
    """
    contents = draft.contents()
    numbers = contents.column("task_index").ravel()
    try:
        words = task_words(contents)
    except Unreadable:
        words = {}
    if words and set(numbers.tolist()) <= set(words):
        return
    told = _told(contents)
    if not set(words.values()) <= set(told.values()):
        raise Unmendable("meta/tasks.parquet: its words are others than the episodes list")
    with draft.replaced(TASKS) as new:
        write_tasks(new, {told[number]: number for number in sorted(told)})
    draft.mended(TASKS, "words of the tasks, by the episodes' lists", len(told), "task")


def _told(contents: Contents) -> dict[int, str]:
    """task_index -> words: those that all episodes with the task list, and no others do."""
    lengths = episode_lengths(contents)
    table = read_episodes(contents)[0]
    if table is None or "tasks" not in table.column_names:
        raise Unmendable("meta/tasks.parquet: no episodes list their tasks: no words are known")
    lists = table["tasks"].to_pylist()
    index, start = contents.column("task_index").ravel(), 0
    done: list[tuple[set[int], set[str]]] = []
    for length, row in zip(lengths.tolist(), match(table, lengths).tolist(), strict=True):
        if row >= 0 and isinstance(lists[row], list):
            done.append((set(index[start : start + length].tolist()), set(lists[row])))
        start += length
    every = set(index.tolist())
    told: dict[int, str] = {}
    for _ in every:  # each round may settle others
        for task in every - told.keys():
            listed = [words for tasks, words in done if task in tasks]
            others = [words for tasks, words in done if task not in tasks]
            possible = set.intersection(*listed) if listed else set()
            possible -= {*told.values(), *(word for words in others for word in words)}
            if len(possible) == 1:
                told[task] = possible.pop()
    if every != set(range(len(every))) or told.keys() != every:
        raise Unmendable(
            "meta/tasks.parquet: which words are whose cannot be told from the episodes' lists"
        )
    return told
