"""Bags as a LeRobot v3.0 dataset, written by `lfr.data`'s own writers."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from lfr.artifacts import write_json, write_whole
from lfr.curation.verify import Report, verify_dataset
from lfr.data.checks import check_dataset
from lfr.data.reopen import compare_with_sources
from lfr.errors import DataError, LfrError
from lfr.importing.bag.clock import check_clock, choose_clock
from lfr.importing.bag.episodes import BagPlan, plan_bag
from lfr.importing.bag.files import find_bags
from lfr.importing.bag.index import BagIndex, index_bag, readers_of
from lfr.importing.bag.lags import Lag, lags_of
from lfr.importing.bag.mapping import BagMapping, Clock, Part
from lfr.importing.bag.parts import PartReader
from lfr.importing.bag.writer import BagWriter
from lfr.importing.dataset import SOURCE
from lfr.progress import progress

MOST_TOLD = 10  # refused episodes in an error


@dataclass(frozen=True)
class Imported:
    """What came of an import.

    Attributes:
        episodes, frames: of the dataset.
        clock: what a message's time is.
        lags: of each topic of a feature.
        refused: the times that are no episode, and why.
        notes: what else is to be known.
        report: of verifying the dataset.
    """

    episodes: int
    frames: int
    clock: Clock
    lags: tuple[Lag, ...]
    refused: tuple[str, ...]
    notes: tuple[str, ...]
    report: Report


def import_bags(paths: Sequence[Path], out: Path, mapping: BagMapping) -> Imported:
    """Write the episodes of bags as a dataset.

    Bags are read twice: for the times of their messages, of which the frames are planned, and for
    the messages that frames want. It is built beside `out`, opened with LeRobotDataset, compared
    with what was read and verified, and only then given its name.

    Raises:
        LfrError: there is something at `out` already.
        DataError: a bag is not what it should be; no episode is left; or the dataset does not read
            back or does not pass `lfr verify`.
    """
    out = Path(out)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise LfrError(f"{out} is there already; name another folder, or remove it")
    readers = readers_of(mapping)
    clock, plans = _plans(paths, mapping, readers)
    with write_whole(out) as partial:
        writer = _write(partial, mapping, readers, plans)
        if any(writer.wrong):  # a second time, without the episodes that were found to be wrong
            plans = [_without(*pair) for pair in zip(plans, writer.wrong, strict=True)]
            shutil.rmtree(partial)
            writer = _write(partial, mapping, readers, plans)
        lags = lags_of(plans, mapping)
        refused = tuple(line for plan in plans for line in plan.refused)
        notes = tuple(line for plan in plans for line in (*plan.index.notes, *plan.notes))
        write_json(partial / SOURCE, {
            "format": "mcap",
            "mapping": mapping,
            "bags": [{"name": b.name, "sha256": d} for b, d in writer.bags.items()],
            "time": clock,
            "lags": lags,
            "refused": refused,
            "notes": notes,
        })  # fmt: skip
        check_dataset(partial, features=writer.features, fps=mapping.fps)
        compare_with_sources(partial, f"lfr/{out.name}", writer.written)
        report = verify_dataset(partial)
        if report.errors:
            raise DataError("the dataset does not pass `lfr verify`", file=out,
                            found="; ".join(map(str, report.errors)))  # fmt: skip
    frames = writer.frames
    return Imported(frames.episodes, frames.frames, clock, lags, refused, notes, report)


def _plans(
    paths: Sequence[Path], mapping: BagMapping, readers: Mapping[Part, PartReader]
) -> tuple[Clock, list[BagPlan]]:
    """The first reading of all bags, by the clock of the first one.

    Of several, one that is not what it should be is refused and the others go on.
    """
    clock: Clock | None = None
    plans = []
    bags = find_bags(paths)
    for bag in progress(bags, "times", "bag"):
        try:
            index = index_bag(bag, mapping, readers)
            if clock is None:
                clock = choose_clock(index, mapping)
            else:
                check_clock(index, mapping, clock)
        except DataError as error:
            if len(bags) == 1:
                raise
            plans.append(BagPlan(BagIndex(bag, {}, {}), refused=[f"refused: {error}"]))
            continue
        plans.append(plan_bag(index, mapping, clock))
        index.forget_times()
    return clock or "log", plans


def _write(
    root: Path, mapping: BagMapping, readers: Mapping[Part, PartReader], plans: Sequence[BagPlan]
) -> BagWriter:
    """The second reading of all bags, into a new folder; whole where nothing was wrong.

    Raises:
        DataError: there is no episode.
    """
    if not any(plan.episodes for plan in plans):
        refused = [line for plan in plans for line in plan.refused]
        raise DataError("no episode that can be taken", file=plans[0].index.bag.path,
                        found="; ".join(refused[:MOST_TOLD]))  # fmt: skip
    root.mkdir()
    with closing(BagWriter(root, mapping, readers)) as writer:
        for plan in progress(plans, "frames", "bag"):
            writer.add(plan)
        writer.compare_sizes(plans)
        if not any(writer.wrong):
            writer.finish()
    return writer


def _without(plan: BagPlan, wrong: Mapping[int, str]) -> BagPlan:
    """A plan without the episodes that are wrong, which it then lists as refused."""
    for number, why in sorted(wrong.items()):
        start, frames = plan.episodes[number].start, plan.episodes[number].frames
        plan.refused.append(f"{plan.index.bag}, {plan.index.at(start)}, {frames} frames: "
                            f"refused: {why}")  # fmt: skip
    return plan.without(set(wrong))
