"""Stage open-loop: how far a mapping between arms without a simulator can be trusted."""

import sys
from pathlib import Path

from lfr.artifacts import write_json, write_whole
from lfr.evaluation import open_loop_figures as figures
from lfr.evaluation.open_loop import open_loop
from lfr.evaluation.open_loop_page import EPISODE, ERRORS, STATES, open_loop_page
from lfr.external import external_arms
from lfr.mapping.mapping_jobs import mapping_job
from lfr.mapping.mapping_params import MappingParams
from lfr.params import read_section
from lfr.program import run_stage
from lfr.scenarios import scenario as scenario_named
from lfr.scenarios import transfer as transfer_named
from lfr.skills.library import MODELS, pipeline_models
from lfr.skills.skill_params import SkillsParams
from pipeline._stage import SeedParams


def main(transfer: str) -> None:
    """Write results/external/<transfer>: report.md, its pictures and report.json."""
    chosen = transfer_named(transfer)
    scenario = scenario_named(chosen.scenario)
    arms = external_arms(scenario.robots)
    job = mapping_job(
        scenario, chosen, read_section(MappingParams, "mapping"),
        read_section(SkillsParams, "skills").held_out, read_section(SeedParams, "seeds").models,
        pipeline_models(scenario, chosen, arms), MODELS / "mapping" / transfer, arms=arms,
    )  # fmt: skip
    report, episodes, states = open_loop(job)
    with write_whole(Path("results/external") / transfer) as folder:
        folder.mkdir()
        write_json(folder / "report.json", report)
        (folder / "report.md").write_text(open_loop_page(report), encoding="utf-8")
        figures.errors_figure(folder / ERRORS, report)
        figures.episode_figure(folder / EPISODE, episodes)
        figures.states_figure(folder / STATES, states, chosen.task)


if __name__ == "__main__":
    sys.exit(run_stage(main))
