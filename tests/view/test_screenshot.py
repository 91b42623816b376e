"""What `take_screenshot` says when the viewer ends at once, in the words of rerun 0.33.1.

What it draws is in `test_screens.py`.
"""

import re
from pathlib import Path

import pytest

from lfr.errors import LfrError
from lfr.view import screenshot
from lfr.view.screenshot import NO_DRIVER, take_screenshot

NO_ADAPTER = (
    "thread 'main' panicked at 'Failed to create render state: CustomNativeAdapterSelectionError("
    '"No graphics adapter was found for the enabled graphics backends (Backends(VULKAN))")\''
)
ONLY_OPENGL = "thread 'main' panicked at 'Failed to get render context'"
OF_ITS_OWN = "thread 'main' panicked at 'index out of bounds'"
AFTER_IT = "stack backtrace:\n  13: main\n\nReport bugs: https://github.com/rerun-io/rerun/issues"


@pytest.mark.parametrize(
    ("panic", "said"),
    [
        pytest.param(NO_ADAPTER, NO_DRIVER, id="no driver"),
        pytest.param(ONLY_OPENGL, NO_DRIVER, id="only OpenGL"),
        pytest.param(OF_ITS_OWN, OF_ITS_OWN, id="a fault of the viewer's own"),
    ],
)
def test_why_the_viewer_ended(
    panic: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    viewer = tmp_path / "viewer"
    viewer.write_text(f"#!/bin/sh\ncat >&2 <<'END'\n\n{panic}\n{AFTER_IT}\nEND\nexit 102\n")
    viewer.chmod(0o755)
    monkeypatch.setattr(screenshot, "executable", lambda: viewer)
    with pytest.raises(LfrError, match=re.escape(said)):
        take_screenshot([tmp_path / "an.rrd"], tmp_path / "picture.png")
    assert not (tmp_path / "picture.png").exists()
