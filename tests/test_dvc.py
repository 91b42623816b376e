"""What dvc.yaml shows of the results, and the picture of it in the documents."""

from pathlib import Path

import pytest

from lfr.artifacts import read_json
from lfr.params import read_yaml
from pipeline._dag import BEGIN, END, SHOWN_IN, collapsed, dvc_dag, main, shown

ROOT = Path(__file__).parent.parent
MERMAID = """flowchart TD
\tnode1["evaluate@a-b"]
\tnode2["record@panda-lift"]
\tnode3["record@sawyer-lift"]
\tnode4["report"]
\tnode2-->node1
\tnode3-->node1
\tnode1-->node4
\tnode2-->node4
"""


@pytest.fixture(scope="module")
def content() -> dict:
    return read_yaml(ROOT / "dvc.yaml")


def test_every_run_is_in_every_plot(content: dict) -> None:
    params = read_yaml(ROOT / "params.yaml")
    runs = {
        f"results/transfer/{transfer}-{method}.csv"
        for transfer in params["transfers"]
        for method in params["methods"]
    }
    plots = [plot for each in content["plots"] if isinstance(each, dict) for plot in each.values()]
    assert plots
    for plot in plots:
        assert set(plot["y"]) == runs
        assert (ROOT / ".dvc/plots" / f"{plot['template']}.json").is_file()


def test_plots_show_columns_that_the_runs_write(content: dict) -> None:
    for each in content["plots"]:
        for plot in each.values() if isinstance(each, dict) else ():
            for file, column in plot["y"].items():
                header = (ROOT / file).read_text().splitlines()[0].split(",")
                assert {plot["x"], column, "seed"} <= set(header), file


def test_the_template_is_filled_with_the_curves() -> None:
    template = read_json(ROOT / ".dvc/plots/seeds.json")
    assert template["encoding"]["detail"]["field"] == "seed"
    assert template["encoding"]["color"] == "<DVC_METRIC_COLOR>"


def test_a_stage_is_one_box() -> None:
    assert collapsed(MERMAID).splitlines() == [
        "```mermaid",
        "flowchart LR",
        '    record["record × 2"]',
        '    evaluate["evaluate"]',
        '    report["report"]',
        "    record --> evaluate",
        "    record --> report",
        "    evaluate --> report",
        "```",
    ]


def test_the_documents_show_the_pipeline_as_it_is() -> None:
    picture = collapsed(dvc_dag(ROOT))
    for name in SHOWN_IN:
        assert shown((ROOT / name).read_text()) == picture, "run `python -m pipeline._dag`"


@pytest.mark.parametrize("old", ["old", ""])
def test_drawing_changes_what_is_between_the_markers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, old: str
) -> None:
    monkeypatch.setattr("pipeline._dag.dvc_dag", lambda project: MERMAID)
    (tmp_path / "docs").mkdir()
    (tmp_path / "README.md").write_text("no markers")
    document = tmp_path / "docs/dvc.md"
    document.write_text(f"before\n{BEGIN}\n{old}\n{END}\nafter\n")
    main(tmp_path)
    assert document.read_text() == f"before\n{BEGIN}\n{collapsed(MERMAID)}\n{END}\nafter\n"
    assert (tmp_path / "README.md").read_text() == "no markers"
