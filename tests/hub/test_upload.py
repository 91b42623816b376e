"""Publishing against a server that speaks the Hub's API, end to end."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from lfr import cli
from lfr.data.tables import DatasetFiles

from .conftest import TOKEN
from .server import Hub, sha256

REPO = "someone/panda-lift"


def publish(path: Path, *options: str, repo: str = REPO) -> int:
    return cli.main(["publish", str(path), "--repo", repo, "--results", "none", *options])


def load(monkeypatch: pytest.MonkeyPatch, cache: Path, **options: object):
    """What `LeRobotDataset(REPO)` gives who has never loaded it."""
    from lerobot.datasets import LeRobotDataset, dataset_metadata, lerobot_dataset

    for module in (dataset_metadata, lerobot_dataset):
        monkeypatch.setattr(module, "HF_LEROBOT_HUB_CACHE", cache / "hub")
    monkeypatch.setattr(dataset_metadata, "HF_LEROBOT_HOME", cache)
    return LeRobotDataset(REPO, video_backend="pyav", **options)


def nothing_loads(monkeypatch: pytest.MonkeyPatch, cache: Path) -> bool:
    """Neither the tag that LeRobot asks for nor what stands on the main branch."""
    for options in ({}, {"revision": "main"}):
        try:
            load(monkeypatch, cache / str(len(options)), **options)
        except Exception:
            continue
        return False
    return True


def large_files(hub: Hub) -> set[str]:
    """SHA-256 of the large files of the published dataset."""
    return {sha256(c) for c, large in hub.repositories["dataset", REPO].tree("main").values()
            if large}  # fmt: skip


def test_what_is_published_is_what_loads(
    hub: Hub, dataset: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from lerobot.datasets import LeRobotDataset

    assert publish(dataset) == 0
    found = load(monkeypatch, tmp_path / "lerobot")
    expected = LeRobotDataset("lfr/panda-lift", root=dataset, video_backend="pyav")
    assert tmp_path in Path(found.root).parents
    assert len(found) == len(expected) == 36
    for theirs, ours in zip(found, expected, strict=True):
        assert theirs.keys() == ours.keys()
        for key, value in ours.items():
            assert np.array_equal(theirs[key], value), key


def test_one_commit_with_our_card_and_the_tag_on_it(hub: Hub, dataset: Path) -> None:
    assert publish(dataset, "--tag", "first") == 0
    repository = hub.repositories["dataset", REPO]
    assert repository.messages == ["initial commit", "Publish panda-lift"]
    assert repository.refs["v3.0"] == repository.refs["first"] == repository.refs["main"]
    tree = repository.tree("v3.0")
    assert tree is not None
    card = tree["README.md"][0].decode()
    assert f'LeRobotDataset("{REPO}"' in card
    assert "(panda-lift.jpg)" in card
    assert tree["panda-lift.jpg"][0].startswith(b"\xff\xd8")
    steps = [request for request in hub.requests if "/storage/" in request or "commit" in request]
    assert "/commit/" in steps[-1]  # after all the large files
    assert "/tag/" in [r for r in hub.requests if r.startswith("POST")][-1]


@pytest.mark.parametrize("step", ["upload", "commit", "answer", "tag"])
def test_cut_and_published_again(
    hub: Hub, dataset: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, step: str,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    from lerobot.datasets import LeRobotDataset

    hub.cut, hub.whole_uploads = {step}, 2
    assert publish(dataset) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.startswith("lfr: error: ")
    assert "run the same command again" in said
    sent = list(hub.uploads)
    repository = hub.repositories["dataset", REPO]
    assert "v3.0" not in repository.refs
    with pytest.raises(Exception, match=r"version|revision"):
        load(monkeypatch, tmp_path / "by-tag")
    if step in ("upload", "commit"):
        assert nothing_loads(monkeypatch, tmp_path)
        assert len(repository.commits) == 1
    assert len(sent) == 2 if step == "upload" else len(sent) > 2

    hub.cut = set()
    assert publish(dataset) == 0
    assert sorted(hub.uploads) == sorted(large_files(hub))  # each of them once, over both
    assert hub.uploads[: len(sent)] == sent
    assert len(repository.commits) == 2
    assert repository.refs["v3.0"] == repository.refs["main"]
    expected = LeRobotDataset("lfr/panda-lift", root=dataset, video_backend="pyav")
    assert len(load(monkeypatch, tmp_path / "after")) == len(expected)


def test_the_former_revision_loads_until_the_next_is_whole(
    hub: Hub, dataset: Path, logs: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from lfr.data.dataset import pack_dataset

    assert publish(dataset, "--with-logs", str(logs)) == 0
    before = dict(hub.repositories["dataset", REPO].refs)
    shorter = tmp_path / "panda-lift"
    pack_dataset(sorted(logs.iterdir())[:2], shorter, video=False)
    hub.cut = {"upload"}
    assert publish(shorter) == 2
    assert hub.repositories["dataset", REPO].refs == before
    assert load(monkeypatch, tmp_path / "former").num_episodes == 3

    hub.cut = set()
    assert publish(shorter) == 0
    tree = hub.repositories["dataset", REPO].tree("v3.0")
    assert tree is not None
    assert not [path for path in tree if path.startswith(("videos/", "logs/"))]
    assert ".gitattributes" in tree
    assert load(monkeypatch, tmp_path / "next").num_episodes == 2


def test_a_tag_of_ones_own_is_not_moved_unless_asked(
    hub: Hub, dataset: Path, logs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from lfr.data.dataset import pack_dataset

    assert publish(dataset, "--tag", "first") == 0
    repository = hub.repositories["dataset", REPO]
    first = repository.refs["first"]
    shorter = tmp_path / "panda-lift"
    pack_dataset(sorted(logs.iterdir())[:2], shorter, video=False)
    assert publish(shorter, "--tag", "first") == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert f"but the tag first names {first[:12]}; choose another, or --move-tags" in said
    assert publish(shorter, "--tag", "second") == 0
    assert publish(dataset, "--tag", "second", "--tag", "first") == 2
    assert "nothing published: the tag first names" in capsys.readouterr().err
    assert repository.refs["first"] == first
    assert repository.refs["second"] == repository.refs["main"] != first
    assert publish(shorter, "--tag", "first", "--move-tags") == 0
    assert repository.refs["first"] == repository.refs["v3.0"] == repository.refs["main"]


def test_publishing_the_same_again_changes_nothing(hub: Hub, dataset: Path) -> None:
    assert publish(dataset) == 0
    refs, uploads = dict(hub.repositories["dataset", REPO].refs), list(hub.uploads)
    assert publish(dataset) == 0
    assert hub.repositories["dataset", REPO].refs == refs
    assert hub.uploads == uploads
    assert len(hub.repositories["dataset", REPO].commits) == 2


def test_logs_beside_the_data(hub: Hub, dataset: Path, logs: Path) -> None:
    assert publish(dataset, "--with-logs", str(logs)) == 0
    tree = hub.repositories["dataset", REPO].tree("v3.0")
    assert tree is not None
    published = DatasetFiles.open(dataset).episodes
    for name, digest in zip(published["log_file"], published["log_sha256"], strict=True):
        assert sha256(tree[f"logs/{name}"][0]) == digest.as_py()
    assert "`logs/` holds" in tree["README.md"][0].decode()


def test_models_are_published_and_load_again(hub: Hub, models: Path) -> None:
    import torch
    from huggingface_hub import snapshot_download

    from lfr.skills.saved_models import load_prior, load_vae

    assert publish(models, repo="someone/skills") == 0
    assert ("model", "someone/skills") in hub.repositories
    folder = Path(snapshot_download("someone/skills"))
    for load_one, place in ((load_vae, "lift+stack/vae"), (load_prior, "lift+stack/prior-lift")):
        found, expected = (load_one(root / place).state_dict() for root in (folder, models))
        assert found.keys() == expected.keys()
        assert all(torch.equal(found[name], expected[name]) for name in expected)
    assert 'snapshot_download("someone/skills")' in (folder / "README.md").read_text()


def test_the_token_is_never_shown(
    hub: Hub, dataset: Path, models: Path, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert publish(dataset, "--dry-run") == 0
    assert publish(dataset) == 0
    hub.fail = {"commit": (400, "bad request with {}")}  # a server that repeats it
    assert publish(models, repo="someone/skills") == 2
    hub.fail = {"create": (403, "no right for {}")}
    assert publish(models, repo="another/skills") == 2
    hub.fail, hub.cut = {}, {"commit"}
    assert publish(models, repo="someone/skills") == 2
    captured = capfd.readouterr()
    shown = captured.out + captured.err
    assert "bad request with" in shown
    assert "Traceback" not in shown
    assert TOKEN not in shown
    trees = (tree for r in hub.repositories.values() for tree in r.commits.values())
    assert not any(TOKEN.encode() in content for tree in trees for content, _ in tree.values())


@pytest.mark.parametrize("token", [None, "hf_anotherMadeUpSecret"])
def test_without_the_right_to_write(
    hub: Hub, dataset: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, token: str | None,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    import huggingface_hub.constants as constants

    monkeypatch.delenv("HF_TOKEN")
    monkeypatch.setattr(constants, "HF_TOKEN_PATH", str(tmp_path / "token"))
    if token:
        (tmp_path / "token").write_text(token)
    assert publish(dataset) == 2
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith("lfr: error: ")
    assert "hf auth login" in line
    assert "HF_TOKEN" in line
    assert hub.repositories == {}


def test_hub_and_token_come_from_the_usual_places(hub: Hub, models: Path, tmp_path: Path) -> None:
    (tmp_path / "token").write_text(TOKEN)  # as `hf auth login` leaves it
    usual = {"HF_ENDPOINT": hub.url, "HF_HOME": str(tmp_path), "HF_HUB_DISABLE_XET": "1"}
    rest = {name: value for name, value in os.environ.items() if not name.startswith("HF_")}
    program = "import sys; from lfr.cli import main; sys.exit(main())"
    done = subprocess.run(
        [sys.executable, "-c", program, "publish", str(models), "--repo", "someone/skills",
         "--results", "none"],
        env={**rest, **usual}, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    commit = hub.repositories["model", "someone/skills"].refs["main"]
    assert f"{hub.url}/someone/skills at {commit}" in done.stdout
    assert TOKEN not in done.stdout + done.stderr


def test_a_card_that_the_hub_refuses_is_told_before_anything_is_sent(
    hub: Hub, dataset: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    own = tmp_path / "card.md"
    own.write_text("---\nlicense: mine\ntags: [robotics]\ntask_categories: [robotics]\n---\n")
    assert publish(dataset, "--card", str(own)) == 2
    assert "license" in capsys.readouterr().err
    assert hub.uploads == []
    assert "v3.0" not in hub.repositories["dataset", REPO].refs


def test_private_is_not_published_to_who_can_see_it(hub: Hub, dataset: Path) -> None:
    assert publish(dataset, "--private") == 0
    assert hub.repositories["dataset", REPO].private
    assert publish(dataset, "--private") == 0
    hub.repositories["dataset", REPO].private = False
    assert publish(dataset, "--private") == 2


def test_what_is_faulty_is_refused_before_the_hub_is_asked(
    hub: Hub, dataset: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    faulty = tmp_path / "panda-lift"
    shutil.copytree(dataset, faulty)
    file = next((faulty / "data").rglob("*.parquet"))
    file.write_bytes(file.read_bytes()[:-100])
    assert publish(faulty) == 2
    assert "cut-off" in capsys.readouterr().err
    assert hub.requests == []
