"""The study of the two judges: episode by episode, and only where both judged the same start."""

from __future__ import annotations

from pathlib import Path

from lfr.artifacts import write_json
from pipeline.paper._judges import agreement


def job(
    folder: Path,
    name: str,
    judge: str,
    outcomes: dict[int, bool],
    stage: str,
    robot: str = "panda",
) -> Path:
    policy = f"work/{stage}/folder/{name}/policy"
    spec = {"policy": {"policy": policy}, "robot": robot, "task": "stack", "judge": judge}
    result = [{"seed": seed, "success": won, "steps": 9} for seed, won in outcomes.items()]
    file = folder / f"{name}-{robot}-{judge}-{min(outcomes)}.json"
    write_json(file, {"function": "run_part", "spec": spec, "result": result})
    return file


def test_judges_are_compared_on_the_same_starts(tmp_path: Path) -> None:
    stage = "paper-learn/lift-lfr"
    files = [
        job(tmp_path, "a", "engine", {1: True, 2: False}, stage),
        job(tmp_path, "a", "engine", {3: True, 4: True}, stage),  # a trial comes in pieces
        job(tmp_path, "a", "robosuite", {1: True, 2: True}, stage),
        job(tmp_path, "b", "engine", {1: True, 2: True}, stage),
        job(tmp_path, "b", "robosuite", {1: False, 2: True}, stage),
        job(tmp_path, "initial", "engine", {1: True}, stage),  # which robosuite never judged
        job(tmp_path, "a", "engine", {1: False, 2: False}, stage, "sawyer"),  # nor on this arm
        job(tmp_path, "c", "engine", {1: True}, "paper-learn/lift-sac"),
    ]
    learned = tmp_path / "learned.json"
    write_json(learned, {"function": "run_part", "spec": {"seed": 0}, "result": {"seconds": 3.0}})
    assert agreement([*files, learned]) == {
        stage: {
            "policies": 2, "episodes": 4, "engine": 3, "robosuite": 3, "differ": 2,
            "engine_all_episodes": 6, "engine_all": 5,
        }
    }  # fmt: skip
