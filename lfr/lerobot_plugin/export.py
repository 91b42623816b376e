"""`lfr export`: a policy of this project as a folder for LeRobot's `--policy.path`."""

from __future__ import annotations

import argparse
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lfr.artifacts import write_whole
from lfr.errors import DataError

if TYPE_CHECKING:
    from lfr.data.own_columns import OwnColumns


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lfr export`."""
    parser.add_argument(
        "policy", type=Path,
        help="a trained policy's folder, or that of a mapping, models/mapping/<transfer>",
    )  # fmt: skip
    parser.add_argument("out", type=Path, help="the folder to write; nothing may be there yet")


def run(arguments: argparse.Namespace) -> int:
    """Carry out `lfr export`, and say how to use what it wrote.

    Raises:
        DataError: no policy and no mapping, a damaged one, or something where it should go.
    """
    exported = export_policy(arguments.policy, arguments.out)
    path = shlex.quote(f"--policy.path={arguments.out}")
    found = "--env.discover_packages_path=lfr.lerobot_plugin"
    if exported.columns is None:
        print(
            f"lerobot-eval {path} {found} --env.type=lfr --env.robot={exported.robot} "
            f"--env.task={exported.task} --seed=0 --eval.n_episodes=100 --eval.batch_size=1"
        )
        return 0
    print(f"{exported.robot} can be asked to {exported.task}; nobody has seen it do so.")
    for column, feature in exported.columns.features.items():
        seen = "answers" if column == exported.columns.selection.action.column else "sees"
        print(f"  {seen} {column}, {feature['shape'][0]} numbers")
    print(f"  at {exported.columns.fps:g} control steps a second")
    print(f"lerobot-eval {path} {found} --env.type=... --eval.batch_size=1")
    return 0


@dataclass(frozen=True)
class Exported:
    """What has been written.

    Attributes:
        robot, task: who acts, and what it does.
        columns: what it sees and answers, where it is known by its datasets alone.
    """

    robot: str
    task: str
    columns: OwnColumns | None = None


def export_policy(folder: Path, out: Path) -> Exported:
    """Write the policy in `folder` as LeRobot's `save_pretrained` would, whole or not at all.

    Args:
        folder: a transferred policy's, or a mapping's, which acts as it did before any learning on
            the target. For a mapping, and for an arm that is not simulated
            here, it reads `params.yaml` too, and the metadata of the arm's datasets.

    Raises:
        DataError: no policy and no mapping, a damaged one, or something where it should go.
    """
    from lfr.embodiments import is_known
    from lfr.lerobot_plugin.configuration_lfr import LfrConfig, features_of, own_features
    from lfr.lerobot_plugin.mapped import columns_of, mapped_actor
    from lfr.lerobot_plugin.modeling_lfr import LfrPolicy
    from lfr.lerobot_plugin.processor_lfr import make_lfr_pre_post_processors
    from lfr.scenarios import transfer as transfer_named
    from lfr.skills.prior import SkillPrior
    from lfr.transfer.model import described, load_policy

    if out.exists():
        raise DataError("there is something already; remove it or name another folder", file=out)
    columns = None
    about: dict[str, Any]
    if (folder / "g").is_dir():
        mapped = mapped_actor(folder)
        actor, columns, transfer = mapped.actor, mapped.columns, mapped.transfer
        about = {"robot": transfer.target, "task": transfer.task, "transfer": transfer.name,
                 "source": transfer.source, "seed": mapped.seed}  # fmt: skip
    else:
        actor, about = load_policy(folder)
        if not is_known(about["robot"]):
            transfer = transfer_named(about["transfer"])
            pi = actor.policy.pi
            assert isinstance(pi, SkillPrior)  # as every method's of the library
            columns = columns_of(transfer, pi.layout_names)
    robot, task = about["robot"], about["task"]
    given, answered = own_features(columns.features) if columns else features_of(robot, task)
    networks, tensors = described(actor, folder / "config.json")
    config = LfrConfig(
        robot=robot,
        task_name=task,
        networks=networks,
        distribution=actor.distribution.name,
        min_sigma=actor.policy.min_sigma,
        columns=columns.described() if columns else {},
        about={key: value for key, value in about.items() if key not in ("robot", "task")},
        input_features=given,
        output_features=answered,
        device="cpu",
        push_to_hub=False,
        license="apache-2.0",
    )
    policy = LfrPolicy(config)
    policy.load_state_dict(tensors)
    with write_whole(out) as partial:
        partial.mkdir()
        policy.save_pretrained(partial)
        for processor in make_lfr_pre_post_processors(config):
            processor.save_pretrained(partial)
    return Exported(robot, task, columns)
