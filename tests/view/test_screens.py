"""What is drawn: by rerun without a screen, and by its viewer in a real browser.

The colours of gripper and success are looked for: nothing but an episode puts them there.
"""

import io
import re
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun.blueprint as rrb
from PIL import Image

from lfr.cli import main
from lfr.errors import LfrError
from lfr.view.blueprint import EpisodeLayout, episode_blueprint
from lfr.view.collection import EPISODE_ALONE, collection_of, save_episodes
from lfr.view.screenshot import NO_DRIVER, take_screenshot
from lfr.view.viewer import viewer_command

from . import chromium
from .conftest import Recorded

# gripper's lane open and closing, success's lane; a theme shades them by up to so much
BLUE, AMBER, GREEN, NEAR = (82, 150, 255), (255, 178, 56), (76, 195, 112), 60
ENOUGH = 100  # pixels
SMALL = (900, 640)


def shows_an_episode(png: bytes) -> bool:
    pixels = np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), int).reshape(-1, 3)
    return all(
        int((np.abs(pixels - color).max(axis=1) < NEAR).sum()) > ENOUGH
        for color in (BLUE, AMBER, GREEN)
    )


@pytest.mark.slow
def test_a_picture_without_a_screen(
    shown: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "episode.png"
    status = main(["view", str(shown), "--screenshot", str(out), "--size", "800x600"])
    if status and NO_DRIVER in capsys.readouterr().err:
        pytest.skip("no Vulkan driver here: apt-get install mesa-vulkan-drivers")
    assert status == 0
    assert Image.open(out).size == (800, 600)
    assert shows_an_episode(out.read_bytes())


@pytest.mark.slow
def test_without_a_driver_it_says_what_to_install(
    shown: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("VK_DRIVER_FILES", "VK_ICD_FILENAMES"):
        monkeypatch.setenv(name, str(tmp_path / "none.json"))
    monkeypatch.setenv("WGPU_BACKEND", "vulkan")
    with pytest.raises(LfrError, match=re.escape(NO_DRIVER)):
        take_screenshot([shown], tmp_path / "none.png", (320, 200))
    assert not (tmp_path / "none.png").exists()


def paused(layout: EpisodeLayout) -> rrb.Blueprint:
    """A browser that draws on the processor falls behind what plays."""
    blueprint = episode_blueprint(layout)
    blueprint.time_panel = rrb.TimePanel(state="collapsed", timeline="time", play_state="Paused")
    return blueprint


@pytest.mark.slow
def test_a_browser_shows_what_is_served(recorded: Recorded, tmp_path: Path) -> None:
    program = chromium.chromium()
    if program is None:
        pytest.skip("no Chromium here: apt-get install chromium-headless-shell")
    collection = collection_of(recorded.log)
    assert collection is not None
    (still,) = save_episodes(
        collection, [0], tmp_path, overlay=replace(EPISODE_ALONE, blueprint=paused)
    )
    command = viewer_command([still], web=True)
    data, page = (command[command.index(flag) + 1] for flag in ("--port", "--web-viewer-port"))
    url = f"http://127.0.0.1:{page}?url=rerun%2Bhttp%3A%2F%2F127.0.0.1%3A{data}%2Fproxy"
    server = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        time.sleep(2)
        png = chromium.look(program, url, shows_an_episode, profile=tmp_path / "p", size=SMALL)
    finally:
        server.terminate()
        server.wait()
    assert shows_an_episode(png)


@pytest.mark.slow
def test_plain_rerun_opens_a_dataset(dataset: Path, tmp_path: Path) -> None:
    """rerun's own importer, which `rerun FOLDER` uses, one recording for each episode."""
    import rerun as rr
    from rerun.experimental import RrdReader

    out = tmp_path / "plain.rrd"
    with rr.RecordingStream("plain") as recording:
        recording.save(out)
        recording.log_file_from_path(dataset)
        recording.flush()
        recording.disconnect()
    reader = RrdReader(out)
    stores = {store.recording_id: store for store in reader.recordings()}
    assert {"episode_0", "episode_1", "episode_2"} <= set(stores)
    chunks = reader.stream(store=stores["episode_1"]).to_chunks()
    entities = {chunk.entity_path for chunk in chunks}
    assert {"/action", "/observation.state", "/next.reward"} <= entities


@pytest.mark.slow
def test_lerobots_own_viewer_opens_a_dataset(dataset: Path, tmp_path: Path) -> None:
    import sys

    from rerun.experimental import RrdReader

    program = Path(sys.executable).with_name("lerobot-dataset-viz")
    command = [str(program), "--repo-id", f"lfr/{dataset.name}", "--root", str(dataset)]
    command += ["--episode-index", "0", "--save", "1", "--output-dir", str(tmp_path)]
    done = subprocess.run([*command, "--num-workers", "0"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    (file,) = tmp_path.glob("*.rrd")
    entities = {chunk.entity_path for chunk in RrdReader(file).stream().to_chunks()}
    assert {"/action", "/state", "/next.reward", "/next.success"} <= entities
