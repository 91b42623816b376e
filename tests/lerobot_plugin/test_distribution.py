"""The distribution by which LeRobot finds the plugin without being told."""

import sys
import tomllib
from pathlib import Path

import pytest
from lerobot.utils.import_utils import register_third_party_plugins

from lfr import __version__

FOLDER = Path(__file__).parents[2] / "plugins" / "lerobot_policy_lfr"


def test_lerobot_imports_it_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    project = tomllib.loads((FOLDER / "pyproject.toml").read_text())["project"]
    assert project["version"] == __version__
    installed = tmp_path / f"{project['name']}-{project['version']}.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text(f"Metadata-Version: 2.4\nName: {project['name']}\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.syspath_prepend(FOLDER)
    monkeypatch.delitem(sys.modules, "lerobot_policy_lfr", raising=False)
    register_third_party_plugins()
    module = sys.modules.pop("lerobot_policy_lfr")
    assert Path(str(module.__file__)).is_relative_to(FOLDER)
    assert set(module.__all__) == {"configuration_lfr", "env_config"}
