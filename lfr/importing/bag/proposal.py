"""The mapping that `lfr columns BAG` proposes: topics and features, to be shortened."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence

from lfr.data.episode import ACTION, IMAGES, STATE
from lfr.errors import DataError
from lfr.importing.bag.files import Bag
from lfr.importing.bag.topics import Names, TopicSummary, kinds, summarise

COMMAND = re.compile(r"command|cmd|action|target|desired|goal|leader|reference", re.IGNORECASE)
COMMANDS = ("JointTrajectory", "JointTrajectoryPoint", "Float64MultiArray", "MultiDOFCommand")
TASK = re.compile(r"task|instruction|language|prompt", re.IGNORECASE)
STATES = ("JointState", "JointStates", "DynamicJointState")
POSITIONS = re.compile(r"(^|\.)(positions?|data)$")
FPS = (5, 10, 15, 20, 25, 30, 50, 60)
USUAL_FPS = 30
SHOWN = 12  # names in a comment
PLAIN = re.compile(r"[A-Za-z_/][\w./]*", re.ASCII)


def proposal(bags: Sequence[Bag]) -> str:
    """A mapping file of the first bag's topics, in YAML.

    All that can be a feature is in it, what is no state, command or picture as a comment. `task` is
    empty where no topic says it: an import refuses that, so that nobody forgets it.

    Raises:
        DataError: there is no bag, it has no messages, or it cannot be read.
    """
    bag, notes = bags[0], []
    topics = summarise(bag, notes)
    if not topics:
        raise DataError("no messages", file=bag.path)
    lines = [f"# {line}" for line in _about(bags, topics, notes)]
    lines += [f"fps: {_fps(topics)}", "robot_type: unknown", *_task(topics), "features:"]
    states = list(_parts(topics, commands=False))
    commands = list(_parts(topics, commands=True))
    rest = list(_rest(topics, {line for line in states + commands}))
    if states:
        lines += [f"  {STATE}:", *(f"    - {line}" for line in states)]
        lines += [f"    # - {line}" for line in rest]
    else:
        lines += [f"  # {STATE}:", *(f"  #   - {line}" for line in rest)]
    for topic in topics:
        if topic.pictures:
            lines.append(f"  {IMAGES}{_camera(topic.name)}: {{topic: {_text(topic.name)}}}")
    if commands:
        lines += [f"  {ACTION}:", *(f"    - {line}" for line in commands)]
    else:
        lines.append(f"  {ACTION}: {{next: {STATE}}}")
    marks = [t for t in topics if t.type.endswith(("/Bool",)) and not t.unread]
    lines.append("# An episode is a bag; or `episodes: {gap: 2.0}`, parted by seconds of silence,"
                 " or by a topic:")  # fmt: skip
    name = marks[0].name if marks else "/recording"
    lines.append(f"# episodes: {{topic: {_text(name)}, start: true, end: false}}")
    return "\n".join(lines) + "\n"


def _about(
    bags: Sequence[Bag], topics: Sequence[TopicSummary], notes: Sequence[str]
) -> Iterator[str]:
    seconds = (max(t.last for t in topics) - min(t.first for t in topics)) / 1e9
    more = f", the first of {len(bags)} bags" if len(bags) > 1 else ""
    yield f"{bags[0]}{more}: {len(topics)} topics, {seconds:.1f} s. Shorten this, then:"
    yield "lfr import BAG ... --mapping THIS.yaml --to FOLDER"
    yield from notes
    for topic in topics:
        rate = f", {topic.rate:.1f} Hz" if topic.rate else ""
        header = ", header" if topic.header else ""
        yield f"{topic.name} ({topic.type}): {topic.messages} messages{rate}{header}"
        if topic.unread:
            yield f"  no feature: {topic.unread}"
        elif topic.pictures:
            yield f"  pictures of {topic.pictures[0]} x {topic.pictures[1]}"
        for path, found in kinds(topic):
            yield f"  {path or 'all'}: {_listed(found)}"


def _parts(topics: Sequence[TopicSummary], *, commands: bool) -> Iterator[str]:
    """The parts of the state, or of the action: positions, where a topic has more than these."""
    for topic in topics:
        kind = topic.type.replace(".", "/").rsplit("/", 1)[-1]
        ordered = bool(COMMAND.search(topic.name)) or kind in COMMANDS
        if ordered != commands or not (commands or kind in STATES):
            continue
        found = list(kinds(topic))
        positions = [(path, names) for path, names in found if POSITIONS.search(path)]
        yield from (_part(topic, path, names) for path, names in positions or found)


def _rest(topics: Sequence[TopicSummary], taken: set[str]) -> Iterator[str]:
    for topic in topics:
        lines = (_part(topic, path, names) for path, names in kinds(topic))
        yield from (line for line in lines if line not in taken)


def _part(topic: TopicSummary, path: str, names: Names | int) -> str:
    said = f", field: {_text(path)}" if path else ""
    named = f", names: {json.dumps(list(names))}" if isinstance(names, tuple) else ""
    return f"{{topic: {_text(topic.name)}{said}{named}}}"


def _task(topics: Sequence[TopicSummary]) -> list[str]:
    for topic in topics:
        if topic.text and TASK.search(topic.name):
            return [f"task: {{topic: {_text(topic.name)}}}"]
    return ['task: ""  # say in words what is done']


def _fps(topics: Sequence[TopicSummary]) -> int:
    """The slowest camera's rate, or a usual one."""
    rate = min((t.rate for t in topics if t.pictures and t.rate), default=USUAL_FPS)
    return min(FPS, key=lambda fps: abs(fps - rate))


def _camera(topic: str) -> str:
    """`front` of /camera/front/image_raw/compressed; what only says that it is a picture goes."""
    words = re.findall(r"\w+", topic)
    plain = {"image", "image_raw", "image_color", "image_rect", "image_rect_color", "compressed",
             "color", "rgb", "raw", "camera", "cameras"}  # fmt: skip
    return "_".join(w for w in words if w not in plain) or "_".join(words) or "camera"


def _listed(found: Names | int) -> str:
    if isinstance(found, int):
        return f"{found} number{'' if found == 1 else 's'}"
    more = f", and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    return ", ".join(found[:SHOWN]) + more


def _text(value: str) -> str:
    return value if PLAIN.fullmatch(value) else json.dumps(value)
