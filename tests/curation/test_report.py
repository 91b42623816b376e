"""The page and the summary: what they show, and that no word of a dataset is obeyed."""

from __future__ import annotations

import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from lfr import cli
from lfr.curation.contents import Contents
from lfr.curation.finding import Finding
from lfr.curation.report.curves import Curves
from lfr.curation.report.html import page, write_html
from lfr.curation.report.markdown import summary
from lfr.curation.report.svg import MOST, drawing
from lfr.curation.report.words import code, escaped, ranges
from lfr.curation.verify import Report, verify_dataset

from . import arm
from .broken import BROKEN
from .test_behaviour import FAULTS, PICTURES, copied


@pytest.fixture(scope="module")
def report(several: Path) -> Report:
    return verify_dataset(several)


class Elements(HTMLParser):
    """All elements and attributes of a page, and its text without its styles."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.open: list[str] = []
        self.feed(text)
        assert self.open == [], self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] != "style":
            self.words.append(data)


def is_harmless(text: str) -> Elements:
    found = Elements(text)
    assert not {"script", "iframe", "object", "link", "base"} & {tag for tag, _ in found.elements}
    for _, attributes in found.elements:
        assert not any(name.startswith("on") for name in attributes)
        for name in ("src", "href"):
            assert (attributes.get(name) or "#").startswith(("#", "data:image/jpeg;base64,"))
    assert "http:" not in text
    assert "https:" not in text
    assert "url(" not in text
    assert "@import" not in text
    return found


def test_the_page_names_all_and_obeys_nothing(several: Path, report: Report) -> None:
    text = "\n".join(page(report))
    found = is_harmless(text)
    words = " ".join(found.words)
    assert "<script>alert(1)</script>" in words
    assert "\x1b" not in text
    assert all(kind in words for kind in ("stuck", "duplicate", "missing-file", "tasks"))
    ids = {a["id"] for _, a in found.elements if a.get("id")}
    assert {a["href"] for t, a in found.elements if t == "a"} <= {f"#{name}" for name in ids}
    svgs = [a for tag, a in found.elements if tag == "svg"]
    assert len(svgs) > 3
    assert all(a["role"] == "img" for a in svgs)
    policy = next(a["content"] for t, a in found.elements if t == "meta" and "http-equiv" in a)
    assert "default-src 'none'" in str(policy)
    assert "script" not in str(policy)


def test_at_most_so_many_of_a_kind_and_the_rest_by_number(tmp_path: Path) -> None:
    found = tuple(Finding("log", f"m{i}", "warning", episode=i) for i in range(9))
    words = " ".join(is_harmless("\n".join(page(Report(tmp_path, found, 9, 9)))).words)
    assert "m4" in words
    assert "m5" not in words
    assert "and 4 more, of episodes 5-8" in words


@pytest.mark.parametrize("name", list(BROKEN)[::3])
def test_whatever_is_broken_has_a_page(dataset: Path, name: str, tmp_path: Path) -> None:
    BROKEN[name][0](dataset)
    found = verify_dataset(dataset)
    write_html(found, tmp_path / "page.html")
    is_harmless((tmp_path / "page.html").read_text())
    assert all(kind in summary(found) for kind in {f.check for f in found.findings})


def test_a_kind_about_pictures_shows_them_beside_a_sound_episodes(tmp_path: Path) -> None:
    import base64
    import io

    from PIL import Image

    of = arm.recording(8)
    PICTURES["black"][0](of)
    path = arm.write(tmp_path / "arm", of, pictures=True)
    found = is_harmless("\n".join(page(verify_dataset(path, pictures=4))))
    images = [a for tag, a in found.elements if tag == "img"]
    assert len(images) == 6
    shown = [
        np.asarray(Image.open(io.BytesIO(base64.b64decode(str(a["src"]).partition(",")[2]))))
        for a in images
    ]
    assert all(str(a["alt"]).startswith(arm.CAMERA) for a in images)
    assert max(picture.mean() for picture in shown[:3]) < 5
    assert min(picture.mean() for picture in shown[3:]) > 50


def test_lines_are_the_rows_and_the_band_their_quantiles(tmp_path: Path) -> None:
    of = arm.recording()
    FAULTS["a spike"][0](of)
    contents = Contents.open(arm.write(tmp_path / "arm", of))
    finding = Finding("jump", "m", "warning", episode=7, column="observation.state: wrist.pos",
                      frames=(30, 31))  # fmt: skip
    sound = [episode for episode in range(16) if episode != 7]
    ((panel,), count) = Curves(contents, sound).panels(finding, 7)
    assert count == 1
    np.testing.assert_array_equal(panel.lines[0].values, of.states[7][:, 2])
    middle = [of.states[e][round((len(of.states[e]) - 1) * 32 / 63), 2] for e in sound]
    assert panel.band is not None
    np.testing.assert_allclose(panel.band[:, 32], np.quantile(middle, (0.05, 0.5, 0.95)))


def test_a_state_stands_beside_its_action(tmp_path: Path) -> None:
    of = arm.recording()
    contents = Contents.open(arm.write(tmp_path / "arm", of))
    finding = Finding("lag", "m", "warning", episode=2, column="action")
    panels, count = Curves(contents).panels(finding, 2)
    assert count == len(panels) == 4
    for place, panel in enumerate(panels):
        state, action = panel.lines
        np.testing.assert_array_equal(state.values, of.states[2][:, place])
        np.testing.assert_array_equal(action.values, of.actions[2][:, place])


def test_columns_by_all_the_names_that_findings_have(tmp_path: Path) -> None:
    contents = Contents.open(arm.write(tmp_path / "arm", arm.recording(6)))
    curves = Curves(contents)
    for column, titles in {
        "observation.state": ["shoulder.pos", "elbow.pos", "wrist.pos", "gripper.pos"],
        "observation.state: elbow.pos, wrist.pos": ["elbow.pos", "wrist.pos"],
        "action.wrist.pos": ["wrist.pos"],
        "action[1]": ["elbow.pos"],
        "stats/action/mean": ["shoulder.pos", "elbow.pos", "wrist.pos", "gripper.pos"],
        "": ["shoulder.pos", "elbow.pos", "wrist.pos", "gripper.pos"],
        "timestamp": ["timestamp (s)"],
        "length": [],
        "action[99]": [],
        "success": [],
    }.items():
        panels, _ = curves.panels(Finding("jump", "m", episode=1, column=column), 1)
        assert [panel.title.rpartition(": ")[2] for panel in panels] == titles, column
    assert curves.panels(Finding("jump", "m", episode=99, column="action"), 99) == ([], 0)


def test_a_long_curve_keeps_its_spike_and_shades_its_frames(tmp_path: Path) -> None:
    from lfr.curation.report.curves import Line, Panel

    values = np.sin(np.arange(100_000) / 5_000)
    values[61_803] = 9.0
    values[5_000:5_010] = np.nan
    text = drawing(Panel("x", (Line("x", values),)), 50.0, (61_803, 61_803), 0)
    assert len(text) < 40 * MOST
    (path,) = re.findall(r'class="own" d="([^"]+)"', text)
    heights = [float(y) for y in re.findall(r"[ML]\S+ ([\d.]+)", path)]
    assert min(heights) < 20 < 60 < sorted(heights)[1]  # the spike alone is near the top
    left, width = map(float, re.findall(r'"shaded" x="([\d.]+)".*?width="([\d.]+)"', text)[0])
    at = 52 + 300 * 61_803 / 99_999
    assert left < at < left + width
    assert "nan" not in text
    for odd in (np.full(3, np.nan), np.zeros(1), np.array([3e38, -3e38]), np.array([np.inf, 1.0])):
        text = drawing(Panel("x", (Line("x", odd),)), 50.0, None, 0)
        assert "nan" not in text
        assert "inf" not in text


def test_nothing_stays_where_the_page_cannot_be_written(
    several: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, report: Report
) -> None:
    from lfr.curation.report import html

    file = tmp_path / "page.html"
    file.write_text("before")

    def fails(_: object) -> list[str]:
        raise KeyboardInterrupt

    monkeypatch.setattr(html, "page", fails)
    with pytest.raises(KeyboardInterrupt):
        write_html(report, file)
    assert file.read_text() == "before"
    assert [one.name for one in tmp_path.iterdir()] == ["page.html"]


def test_the_summary_is_short_and_obeys_nothing(several: Path, tmp_path: Path) -> None:
    file = tmp_path / "summary.md"
    arguments = ["--markdown", str(file), "--html", str(tmp_path / "page.html")]
    assert cli.main(["verify", str(several), *arguments]) == 0
    text = file.read_text()
    assert "17 episodes" in text.splitlines()[0]
    rows = [line for line in text.splitlines() if line.startswith("| `")]
    assert [row.split("|")[1].strip() for row in rows] == [
        "`missing-file`", "`tasks`", "`duplicate`", "`stuck`",
    ]  # fmt: skip
    assert all(len(re.split(r"(?<!\\)\|", row)) == 7 for row in rows)
    # outside of code nothing of the dataset stands
    plain = re.sub(r"`[^`]*`", "", text)
    assert "script" not in plain
    assert "@someone" not in plain
    assert text.count("<details>") == text.count("</details>") == 1


def test_many_findings_fit_a_comment() -> None:
    found = tuple(Finding("log", "the log is not there", "warning", "meta/episodes", i, "log_file",
                          found="x" * 300) for i in range(20_000))  # fmt: skip
    text = summary(Report(Path("x"), found, 20_000, 9, lengths=(1,) * 20_000))
    assert len(text) < 65_536
    assert "and 19950 more" in text
    assert "0-19999" in text


def test_words_are_shown_as_they_are() -> None:
    assert escaped("<b>&\"'\ud800\x00é") == "&lt;b&gt;&amp;&quot;&#x27;\ufffd\ufffdé"
    assert code("a`b\n c|d") == "`a'b c|d`"
    assert ranges([3, 7, 8, 9, 11]) == "3, 7-9, 11"
    assert ranges(range(0, 100, 2), most=3) == "0, 2, 4 and 47 more"
    assert ranges([]) == ""


def test_a_dataset_that_is_all_copies_has_figures_too(tmp_path: Path) -> None:
    of = arm.recording(6)
    copied(of)
    path = arm.write(tmp_path / "arm", of)
    shutil.rmtree(path / "meta/stats", ignore_errors=True)
    is_harmless("\n".join(page(verify_dataset(path))))


def test_a_folder_is_not_written_over(several: Path, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder/kept").write_text("kept")
    for option in ("--html", "--markdown"):
        assert cli.main(["verify", str(several), option, str(tmp_path / "folder")]) == 2
        inside_a_file = str(tmp_path / "folder/kept/page")
        assert cli.main(["verify", str(several), option, inside_a_file]) == 2
    assert (tmp_path / "folder/kept").read_text() == "kept"
