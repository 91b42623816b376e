"""Reading an `.rrd` file back."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
from rerun.experimental import RrdReader

Column = tuple[np.ndarray | None, list[Any]]


def read(path: Path) -> dict[str, dict[str, Column]]:
    """Entity -> component such as `Scalars:scalars` -> frames or steps (None if static), values."""
    entities: dict[str, dict[str, Column]] = defaultdict(dict)
    for chunk in RrdReader(path).stream().to_chunks():
        batch = chunk.to_record_batch()
        index = None
        for name in ("frame", "env_steps"):
            if name in chunk.timeline_names:
                index = batch.column(name).to_numpy(zero_copy_only=False)
        for name in batch.schema.names:
            if ":" in name and (index is not None or chunk.is_static):
                values = batch.column(name).to_pylist()
                before = entities[chunk.entity_path].get(name)
                if before is not None and index is not None and before[0] is not None:
                    index_all = np.concatenate([before[0], index])
                    entities[chunk.entity_path][name] = (index_all, before[1] + values)
                else:
                    entities[chunk.entity_path][name] = (index, values)
    return dict(entities)


def rows(path: Path, entity: str, component: str) -> np.ndarray:
    """The values of one component over time, as an array."""
    return np.array(read(path)[entity][component][1], dtype=np.float64).squeeze()
