"""The memory that importing a bag takes does not grow with the bag."""

import subprocess
import sys
import tracemalloc
from array import array
from pathlib import Path

import pytest
from mcap.writer import CompressionType

from lfr.importing.bag.episodes import plan_bag
from lfr.importing.bag.files import Bag
from lfr.importing.bag.index import BagIndex, Topic
from lfr.importing.bag.mapping import BagMapping, Next, Part

from . import ros2

STATUS = Path("/proc/self/status")
RATE = 10
FEW, MANY = 30, 150  # pictures of 1 MB, most of which stands beside the pixels: to encode little
PADDING = 25_000  # bytes of each of 40 rows
MIB = 2**20
STATE, CAMERA = "/joint_states", "/front/image_raw"
MAPPING = BagMapping(
    fps=RATE,
    features={
        "observation.state": Part(STATE, "position"),
        "observation.images.front": Part(CAMERA),
        "action": Next("observation.state"),
    },
    task="push the cube",
)

# In a process of its own, whose most memory is that of the bags alone. All but what LeRobot does at
# the end, whose libraries take more than both bags hold.
IMPORT = """
import sys
from contextlib import closing
from pathlib import Path
from lfr.importing.bag.episodes import plan_bag
from lfr.importing.bag.files import find_bags
from lfr.importing.bag.index import index_bag, readers_of
from lfr.importing.bag.writer import BagWriter
from tests.importing.test_bag_memory import MAPPING, STATUS

for name in sys.argv[2:]:
    readers = readers_of(MAPPING)
    plan = plan_bag(index_bag(find_bags([Path(name)])[0], MAPPING, readers), MAPPING, "header")
    with closing(BagWriter(Path(sys.argv[1], Path(name).stem), MAPPING, readers)) as writer:
        writer.add(plan)
    status = dict(line.split(":", 1) for line in STATUS.read_text().splitlines())
    print(writer.frames.frames, int(status["VmHWM"].split()[0]) * 1024)
"""


def bag(path: Path, pictures: int) -> Path:
    image = ros2.picture(9)
    messages = []
    for k in range(pictures):
        messages.append(ros2.joints(STATE, k / RATE, ("shoulder", "elbow"), (k, -k)))
        messages.append(ros2.raw(CAMERA, k / RATE, image, "rgb8", padding=PADDING))
    return ros2.write(path, messages, compression=CompressionType.NONE, chunk_size=768 * 1024)


@pytest.mark.skipif(not STATUS.is_file(), reason="Linux alone says the most memory")
def test_a_bag_of_many_pictures_takes_no_more_than_one_of_few(tmp_path: Path) -> None:
    few, many = bag(tmp_path / "few.mcap", FEW), bag(tmp_path / "many.mcap", MANY)
    larger = many.stat().st_size - few.stat().st_size
    assert larger > 100 * MIB
    command = [sys.executable, "-c", IMPORT, str(tmp_path / "out"), str(few), str(many)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    (frames_few, small), (frames_many, large) = (map(int, line.split())
                                                 for line in done.stdout.splitlines())  # fmt: skip
    assert (frames_few, frames_many) == (FEW - 1, MANY - 1)
    assert large - small < larger / 4, f"{(large - small) / MIB:.0f} MiB more"


def test_planning_takes_few_bytes_of_a_message() -> None:
    """Of five hours at 1 kHz, as of minutes; what the messages' times themselves take is no part of
    it."""
    count = 1_000_000
    times = array("q", range(ros2.START, ros2.START + count * 10**6, 10**6))
    topics = {name: Topic(name, "", times, times) for name in (STATE, CAMERA)}
    index = BagIndex(Bag(Path("take"), ()), topics, {}, first=ros2.START)
    tracemalloc.start()
    try:
        plan = plan_bag(index, MAPPING, "log")
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert plan.episodes[0].steps == count * RATE // 1000
    # 16 bytes of each message of both topics are kept until all is planned
    assert most / count < 2 * 16 + 48
