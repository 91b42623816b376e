"""How long someone waits who browses: for the list of ten thousand episodes, for one episode.

    python -m benchmarks.browsing [--dataset data/lerobot/panda-lift] [--repeats 5]

The large dataset is the given one, without its videos, many times over under new numbers. Each
figure is the wall clock with the libraries loaded and the arm's geometry cached, as a part of what
it may be: it needs a quiet machine. An episode counts until rerun can be handed its recording.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from benchmarks._figures import FOLDER, Figure, show, within, write
from lfr.artifacts import read_json, write_json
from lfr.view.collection import collection_of
from lfr.view.listing import dataset_entries, table
from lfr.view.recordings import Wanted, recordings
from lfr.view.selection import Ranges, Selection

EPISODES = 10_000
LIST_SECONDS, EPISODE_SECONDS = 5.0, 3.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--dataset", type=Path, default=Path("data/lerobot/panda-lift"))
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--out", type=Path, default=FOLDER)
    arguments = parser.parse_args()
    small, repeats = arguments.dataset, arguments.repeats
    with tempfile.TemporaryDirectory() as name:
        large = multiplied(small, Path(name) / small.name, EPISODES)
        figures = [
            wait("list/10000-episodes", LIST_SECONDS, lambda: listed(large), repeats),
            wait("episode/with-video", EPISODE_SECONDS, lambda: opened(small, 1), repeats),
            wait("episode/last-of-10000", EPISODE_SECONDS,
                 lambda: opened(large, EPISODES - 1), repeats),
        ]  # fmt: skip
    print(write("browsing", figures, arguments.out))


def listed(dataset: Path) -> None:
    entries = dataset_entries(dataset)
    assert len(entries) == EPISODES
    table(entries)


def opened(dataset: Path, number: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        wanted = Wanted(Selection(episodes=Ranges.parse(str(number))))
        (file,) = recordings(dataset, Path(folder), wanted).files
        assert file.stat().st_size > 0


def wait(name: str, limit: float, act: Callable[[], None], repeats: int) -> Figure:
    """The median wait (s), as a part of the longest that it may be."""
    act()
    waits = []
    for _ in range(repeats):
        begun = time.perf_counter()
        act()
        waits.append(time.perf_counter() - begun)
    figure = within(name, "s", limit, waits)
    show(figure)
    return figure


def multiplied(dataset: Path, out: Path, episodes: int) -> Path:
    """The dataset's episodes over and over, state only, until there are so many."""
    info = read_json(dataset / "meta" / "info.json")
    features = {key: f for key, f in info["features"].items() if f["dtype"] != "video"}
    frames = pa.concat_tables(map(pq.read_table, sorted((dataset / "data").rglob("*.parquet"))))
    rows = pa.concat_tables(
        map(pq.read_table, sorted((dataset / "meta" / "episodes").rglob("*.parquet")))
    )
    rows = rows.select([name for name in rows.column_names if "images" not in name])
    assert collection_of(dataset) is not None
    times = -(-episodes // rows.num_rows)
    _write(out / "meta" / "episodes", rows, times, {
        "episode_index": rows.num_rows,
        "dataset_from_index": frames.num_rows,
        "dataset_to_index": frames.num_rows,
    }, episodes)  # fmt: skip
    _write(out / "data", frames, times, {"episode_index": rows.num_rows, "index": frames.num_rows})
    info |= {"features": features, "total_episodes": episodes, "splits": {"train": f"0:{episodes}"}}
    write_json(out / "meta" / "info.json", info)
    return out


def _write(
    folder: Path, table: pa.Table, times: int, growing: dict[str, int], rows: int | None = None
) -> None:
    """The table's rows `times` over, or so many of them; the growing columns go on counting."""
    file = folder / "chunk-000" / "file-000.parquet"
    file.parent.mkdir(parents=True, exist_ok=True)
    with pq.ParquetWriter(file, table.schema) as writer:
        for k in range(times):
            part: Any = table
            for name, by in growing.items():
                place = part.column_names.index(name)
                field = part.schema.field(name)
                column = np.asarray(part[name].to_numpy()) + k * by
                part = part.set_column(place, field, pa.array(column, field.type))
            left = None if rows is None else max(rows - k * table.num_rows, 0)
            writer.write_table(part.slice(0, left))


if __name__ == "__main__":
    main()
