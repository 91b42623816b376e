"""Written whole or not at all, found again by fingerprint, and equal when read back."""

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from lfr import artifacts
from lfr.artifacts import (
    as_json,
    code_fingerprint,
    file_hash,
    fingerprint,
    load_model,
    parse_json,
    provenance,
    read_json,
    save_model,
    work_folder,
    write_json,
    write_whole,
)
from lfr.errors import DataError


def test_a_file_appears_whole(tmp_path: Path) -> None:
    final = tmp_path / "new" / "a.txt"
    with write_whole(final) as partial:
        assert partial.suffix == ".txt"
        partial.write_text("one")
        assert not final.exists()
    assert [path.name for path in final.parent.iterdir()] == ["a.txt"]
    assert final.read_text() == "one"


def test_a_folder_replaces_a_folder_at_the_end(tmp_path: Path) -> None:
    final = tmp_path / "model"
    for content in ("old", "new"):
        with write_whole(final) as partial:
            (partial / "deep").mkdir(parents=True)
            (partial / "deep" / f"{content}.txt").write_text(content)
            if content == "new":
                assert (final / "deep" / "old.txt").exists()
    assert [path.name for path in tmp_path.rglob("*.txt")] == ["new.txt"]
    assert list(tmp_path.iterdir()) == [final]


def _not_there(*_: object) -> bool:
    return False


def test_where_names_cannot_be_exchanged_a_folder_is_replaced_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(artifacts, "_exchange", _not_there)
    test_a_folder_replaces_a_folder_at_the_end(tmp_path)
    final, renamed = tmp_path / "model", Path.rename

    def broken(path: Path, to: Path) -> Path:
        if path.name == ".partial-model":
            raise OSError("the disk is gone")
        return renamed(path, to)

    monkeypatch.setattr(Path, "rename", broken)
    with pytest.raises(OSError, match="gone"), write_whole(final) as partial:
        partial.mkdir()
    assert [path.name for path in tmp_path.rglob("*.txt")] == ["new.txt"]
    assert list(tmp_path.iterdir()) == [final]


@pytest.mark.parametrize("renamed", [True, False])
def test_what_a_kill_between_two_renames_leaves_is_put_right(tmp_path: Path, renamed: bool) -> None:
    before, final = tmp_path / ".before-model", tmp_path / "model"
    for folder in (before, final) if renamed else (before,):
        folder.mkdir()
        (folder / "a.txt").write_text(folder.name)
    with pytest.raises(KeyboardInterrupt), write_whole(final):
        raise KeyboardInterrupt  # the next attempt, which fails: what was whole is there again
    assert list(tmp_path.iterdir()) == [final]
    assert (final / "a.txt").read_text() == ("model" if renamed else ".before-model")


def test_a_failure_leaves_what_was_there(tmp_path: Path) -> None:
    final = tmp_path / "a.txt"
    final.write_text("old")
    with pytest.raises(FileNotFoundError), write_whole(final) as partial:
        shutil.move(shutil.copy(__file__, partial), tmp_path / "no" / "folder")
    assert final.read_text() == "old"
    assert list(tmp_path.iterdir()) == [final]


def test_a_body_that_writes_nothing_is_a_fault(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), write_whole(tmp_path / "a.txt"):
        pass


def test_killed_while_writing_leaves_nothing_under_the_final_name(tmp_path: Path) -> None:
    program = """
import os, signal, sys
from pathlib import Path
from lfr.artifacts import write_whole
with write_whole(Path(sys.argv[1])) as partial:
    partial.mkdir()
    (partial / "half.txt").write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""
    final = tmp_path / "data"
    done = subprocess.run([sys.executable, "-c", program, str(final)], check=False)
    assert done.returncode == -signal.SIGKILL
    assert not final.exists()
    with write_whole(final) as partial:  # the next attempt starts clean
        partial.mkdir()
        (partial / "whole.txt").write_text("whole")
    assert [path.name for path in tmp_path.rglob("*.txt")] == ["whole.txt"]


def test_json_comes_back_and_nan_does_not_get_in(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    write_json(path, {"b": (1, np.float32(0.5)), "a": Path("x/y")})
    assert read_json(path) == {"b": [1, 0.5], "a": "x/y"}
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(path, {"a": float("nan")})
    assert read_json(path)["a"] == "x/y"


@pytest.mark.parametrize("depth", [65, 900, 200_000])
@pytest.mark.parametrize("brackets", ["[]", ('{"a":', "}")])
def test_json_that_is_nested_deeper_than_python_can_follow(depth: int, brackets: str) -> None:
    text = brackets[0] * depth + "1" + brackets[1] * depth
    with pytest.raises(ValueError, match="deep"):
        parse_json(text)
    text = brackets[0] * 60 + "1" + brackets[1] * 60
    assert parse_json(f"[{text}, {text}]") == json.loads(f"[{text}, {text}]")


def test_json_missing_or_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    with pytest.raises(DataError, match=r"the file is missing: .*a\.json$"):
        read_json(path)
    path.write_text('{"a": ')
    with pytest.raises(DataError, match=r"cut off or no JSON: .*a\.json, found Expecting value"):
        read_json(path)


@dataclass(frozen=True)
class Spec:
    robot: str
    seed: int


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@given(json_values)
def test_fingerprint_is_that_of_the_value(value: object) -> None:
    again = json.loads(json.dumps(value))
    if isinstance(again, dict):
        again = dict(reversed(again.items()))
    assert fingerprint(value) == fingerprint(again)
    assert fingerprint(value) != fingerprint([value])


def test_fingerprint_of_dataclasses_and_files(tmp_path: Path) -> None:
    assert fingerprint(Spec("panda", 1)) == fingerprint({"seed": 1, "robot": "panda"})
    assert fingerprint(Spec("panda", 1)) != fingerprint(Spec("panda", 2))
    file = tmp_path / "a.bin"
    file.write_bytes(b"one")
    before = fingerprint(file)
    assert fingerprint({"file": file}) == fingerprint({"file": str(file)})  # inside: by name
    file.write_bytes(b"two")
    assert fingerprint(file) != before  # a part itself: by content


def test_hash_of_a_folder(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"one")
    assert file_hash(tmp_path / "a") == hashlib.sha256(b"one").hexdigest()
    before = file_hash(tmp_path)
    (tmp_path / "__pycache__").mkdir()
    (tmp_path / "__pycache__" / "a.pyc").touch()
    assert file_hash(tmp_path) == before
    (tmp_path / "a").rename(tmp_path / "b")
    assert file_hash(tmp_path) != before
    with pytest.raises(DataError, match="the file is missing"):
        file_hash(tmp_path / "a")


def test_as_json_refuses_what_json_cannot_hold() -> None:
    with pytest.raises(TypeError, match="object is not a value that JSON can hold"):
        as_json({"a": object()})


def test_code_fingerprint_sees_code_and_not_comments(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lfr.artifacts.__file__", str(tmp_path / "lfr" / "artifacts.py"))
    module = tmp_path / "lfr" / "room" / "one.py"
    module.parent.mkdir(parents=True)
    module.write_text("x = 1\n")
    before = code_fingerprint("lfr.room")
    module.write_text("# why\nx  =  1\n")
    assert code_fingerprint("lfr.room") == before
    module.write_text("x = 2\n")
    assert code_fingerprint("lfr.room") != before
    assert code_fingerprint("lfr.room") == code_fingerprint("lfr.room.one", "lfr.room")
    with pytest.raises(DataError, match="no such package"):
        code_fingerprint("lfr.cellar")


def test_work_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LFR_WORK", str(tmp_path / "w"))
    folder = work_folder("record", "abc")
    assert folder == tmp_path / "w" / "record" / "abc"
    assert folder.is_dir()


def test_a_model_comes_back(tmp_path: Path) -> None:
    weight = torch.randn(3, 4, generator=torch.Generator().manual_seed(0))
    tensors = {"a": weight, "shared": weight, "b": weight.t(), "c": torch.tensor(3)}
    save_model(tmp_path / "m", {"latent": 10, "names": ("x",)}, tensors)
    config, loaded = load_model(tmp_path / "m")
    assert config == {"latent": 10, "names": ["x"]}
    assert loaded.keys() == tensors.keys()
    assert all(torch.equal(loaded[name], tensor) for name, tensor in tensors.items())


def test_a_model_cut_off(tmp_path: Path) -> None:
    save_model(tmp_path / "m", {}, {"a": torch.zeros(100)})
    file = tmp_path / "m" / "model.safetensors"
    os.truncate(file, 200)
    with pytest.raises(DataError, match=r"cut off or no safetensors: .*model\.safetensors, found"):
        load_model(tmp_path / "m")
    file.unlink()
    with pytest.raises(DataError, match=r"the file is missing: .*model\.safetensors"):
        load_model(tmp_path / "m")


def test_provenance_names_this_revision() -> None:
    made = provenance()
    head = subprocess.run(
        ["git", "rev-parse", "HEAD"], cwd=Path(__file__).parent, capture_output=True, text=True
    )
    assert made["revision"] == head.stdout.strip()
    assert made["packages"]["numpy"] == np.__version__
