"""The small files of a dataset's folder `meta`, as LeRobot writes them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def write_json(path: Path, content: Any, *, allow_nan: bool = False) -> None:
    """info.json or stats.json. Raises ValueError for NaN, unless it is allowed."""
    text = json.dumps(content, indent=4, ensure_ascii=False, allow_nan=allow_nan)
    path.write_text(text, encoding="utf-8")


def write_tasks(path: Path, tasks: Mapping[str, int]) -> None:
    """tasks.parquet, of the tasks' words -> task_index."""
    import pandas as pd

    index = pd.Index(list(tasks), name="task")
    pd.DataFrame({"task_index": list(tasks.values())}, index=index).to_parquet(path)
