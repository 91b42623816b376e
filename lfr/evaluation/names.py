"""What tables call things, and what the paper's tables say."""

from __future__ import annotations

from collections.abc import Mapping

NAMES = {
    "own_arm": "own arm", "identity": "identity", "no_generator": "no generator",
    "linear": "linear", "lfr": "LfR", "recoded": "recoded", "retarget": "retarget",
    "oracle": "oracle", "bc_rnn": "BC+RNN", "ap": "AP", "sac": "SAC", "spirl": "SPiRL",
    "lift": "Lift", "stack": "Stack", "pick_place": "Pick-Place", "nut_assembly": "Nut Assembly",
    "panda": "Panda", "sawyer": "Sawyer", "ur5e": "UR5e", "iiwa": "iiwa", "kinova3": "Kinova3",
    "xarm7": "xArm7", "jaco": "Jaco", "osc_pose": "Cartesian", "joint_position": "joints",
}  # fmt: skip

PAPER: Mapping[tuple[str, str], Mapping[str, float]] = {
    ("lift", "panda"): {"bc_rnn": 42.0, "ap": 56.6, "sac": 89.0, "lfr": 98.0},
    ("stack", "sawyer"): {"bc_rnn": 36.0, "ap": 58.0, "sac": 40.5, "lfr": 92.0},
    ("stack", "panda"): {
        "bc_rnn": 42.8, "ap": 37.0, "sac": 30.2, "lfr": 90.2,
        "no_generator": 5.0, "only_lift": 67.8, "only_nut_assembly": 87.6,
    },
    ("pick_place", "sawyer"): {
        "bc_rnn": 16.3, "ap": 10.6, "sac": 0.0, "lfr": 82.5,
        "no_generator": 3.5, "only_lift": 42.4, "only_nut_assembly": 76.0,
    },
}  # fmt: skip
"""Its Tables I to III, percent, by new task and target; it does not name the controller."""
