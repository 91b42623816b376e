"""results/paper/report.md: everything in one place, with the protocol and what was run."""

from __future__ import annotations

import re

from lfr.evaluation.evidence.claims import disagreements, standings
from lfr.evaluation.evidence.conclusions import conclusions_table
from lfr.evaluation.evidence.cost import hours, time_of_runs, time_of_tables
from lfr.evaluation.evidence.curves import LEVELS
from lfr.evaluation.evidence.figures import FIGURES, others
from lfr.evaluation.evidence.findings import findings, short_table, verdict
from lfr.evaluation.evidence.pairs import NO_LEARNING
from lfr.evaluation.evidence.parts import TITLE as WHICH
from lfr.evaluation.evidence.parts import parts_section
from lfr.evaluation.evidence.plain import TITLE, plain_section, plain_summary
from lfr.evaluation.evidence.published import TABLES, TASKS, TRIALS
from lfr.evaluation.evidence.reasons import reasons
from lfr.evaluation.evidence.records import STAGES, Evidence, made_again
from lfr.evaluation.evidence.summary import first_starts, summaries
from lfr.evaluation.evidence.tables import (
    methods_table,
    overall_table,
    paper_table,
    questions_table,
)
from lfr.evaluation.evidence.targets import MARK, targets_table
from lfr.evaluation.tables import stage_table

TITLES = {
    "figure3": "Figure 3: scenario 1, the paper's methods",
    "figure4": "Figure 4: scenario 2, the paper's methods",
    "ablations": "Ablations while they learn",
    "questions": "Other priors and a shared VAE while they learn",
    "reference": "SAC on Panda's Lift beside robosuite-benchmark's",
}


def report(evidence: Evidence) -> str:
    """Markdown; what is not measured yet is a dash."""
    levels = ", ".join(f"{100 * level:.0f}" for level in LEVELS)
    return f"""# The evidence

## In short

![Final success of every method](headline.svg)

Interquartile means over seeds with their intervals, in percent of held-out episodes. A method
counts as not below LfR where its interval overlaps LfR's or lies above it, which does not prove
them equal.

{short_table(evidence)}
{verdict(evidence) or ""}

What the paper concludes, and in how many comparisons of task and reward it is so here, the
intervals lying apart:

{conclusions_table(evidence)}
{plain_summary(evidence) or ""}
{findings(evidence)}

## How it was measured

{_protocol(evidence)}

## What was to be reached

The goal is for the mean over seeds of the final held-out rates. Each was set above the paper's
figure and before these runs, though rates of one seed each, near the goals, were known by then.
"Reached in" is 0 where the policy is there before learning, otherwise the environment steps at
the first evaluation during learning, of a few starts for each seed, whose mean over seeds is; a
later one may be lower again. "In time" asks that of the budget "in steps", or that the whole run
be within it, as every run is whose budget is larger than its own length. LfR is above every other
where the lower end of its interval is above the upper end of each other method's, and of the links
without learning {", ".join(f"`{link}`" for link in NO_LEARNING)}; its ablations and the oracles are
not compared; "so far" where a comparison is still missing. {MARK}: see the next section.

{targets_table(evidence)}
## Who is not below LfR

Interquartile means with their intervals. "Not told apart" means that the intervals overlap. Each
is compared with LfR's of the seeds that both have. {MARK} marks those that are not below LfR by
this rule, though LfR's mean is above theirs by the interval of the difference: of five seeds the
interquartile mean leaves out the worst, and intervals may overlap where that of the difference
does not contain 0.

{standings(evidence)}

{_tables(evidence)}
{_figures(evidence)}
## Every method

Area: under the curve of the running evaluations, over its length. Steps to {levels} %: the first
running evaluation that is there, median over seeds. P(LfR better): the probability that a seed of
LfR is above one of the method, ties counting half; its interval has no width where all pairs of
seeds agree. Zero-shot: before any learning. Robosuite: the final policy in stock robosuite, on the
first {first_starts(evidence)} starts only, which may be easier or harder than all of them. Each
seed's final rate is in the order of the seeds. BC+RNN takes no reward and is the same under each.

{_methods(evidence)}
### Over all tasks

Over the tasks that the method and LfR both have runs of, stratified by task, of the seeds that
both have. The difference of the means is in points; its interval is the bootstrap's alone, without
Wilson's, so it is narrower than those of the means.

{overall_table(evidence)}
## Questions that need no learning

A link is a policy put together from chosen parts (whose prior, which mapping, whose decoder, which
arm) and judged without any learning. Success on the new task: mean over seeds with its bootstrap
interval over seeds and episodes, and each seed.

{questions_table(evidence)}
## {TITLE}

The paper says of its demonstrations that they were collected in simulation. Ours are disturbed,
models see them moved and blurred, and half of each skill is carried out. Section `plain` of
paper/params.yaml sets these choices of docs/method.md back to the paper's reading, all at once;
then demonstrations are recorded, models trained and judged on the same starts once more. Mean over
the same seeds in both rows, with its bootstrap interval, and each seed. A task counts as fallen or
risen where these intervals do not overlap; with three seeds far apart, overlapping says little.

{plain_section(evidence)}{_parts(evidence)}
## Where this disagrees with the paper

The paper's figures whose interval lies apart from that of our mean: Wilson's, as if each were the
mean of {TRIALS} trials, which it says it is.

{disagreements(evidence)}
{reasons(evidence, evidence.methods())}

## What was run on what

{_stages(evidence)}
"""


def _protocol(evidence: Evidence) -> str:
    tried = sorted({run.episodes for run in evidence.runs})
    episodes = " or ".join(map(str, tried)) or "no"
    seeds = sorted({run.seed for run in evidence.runs})
    return f"""A seed is a whole repetition: the split of the demonstrations, skill models, mapping,
and learning. Every final policy is judged at a fixed number of environment steps on the same
{episodes} held-out starts by this project's engine, and on the first {first_starts(evidence)}
of them in robosuite's own environments, Sawyer's contact with its base excluded
([simulation](../../docs/simulation.md)).
Nothing was trained on these starts, and no value was chosen by them; that something had to be
mended was seen on them more than once ([Limits](../../docs/evidence.md#limits), Tuning). Success
is robosuite's own check, at any step within the horizon. All environment steps count, the warm-up
included. Seeds: {", ".join(map(str, seeds)) or "none"}.

Intervals are of 95 %. The interquartile mean (IQM) leaves out the lowest and the highest quarter
of the seeds, of three none. Its interval is a stratified bootstrap over seeds (Agarwal et al. 2021)
and, added to theirs, over the episodes of each, and never narrower than Wilson's of as many
episodes as there are starts, which all policies share. With three to five seeds
a bootstrap is rather too narrow than too wide: a seed that fails now and then may not have been
drawn. Every number is computed from the files beside this one, by
`python -m pipeline.paper.report`.{_made_again(evidence)}"""


def _made_again(evidence: Evidence) -> str:
    """Where runs of one seed began with two trainings of its models: a sentence, or nothing."""
    tasks = [TASKS[transfer] for transfer in TASKS if made_again(evidence, transfer)]
    if not tasks:
        return ""
    return f""" The models of
{"; ".join(tasks)} were trained twice, from two recordings of the demonstrations: some methods
began with the one, some with the other, so two runs of one seed need not share their models, and
what is judged before learning may differ from the same link by a few points
([Reproducibility](../../docs/evidence.md#what-is-measured))."""


def _parts(evidence: Evidence) -> str:
    found = parts_section(evidence)
    if found is None:
        return ""
    return f"""
### {WHICH}

Between ours and the paper's reading: one part of the choices set back and the rest kept (is this
part necessary?), or one part kept and the rest set back (is it enough?). A column is of the same
seeds in every row. Where seeds lie far apart, "not told apart" is no answer.

{found}"""


def _tables(evidence: Evidence) -> str:
    return "\n".join(_demoted(paper_table(table, evidence)) for table in TABLES.values())


def _figures(evidence: Evidence) -> str:
    shown = [
        name for name, figure in FIGURES.items()
        if figure.links or others(figure, evidence)  # the paper's figures, or something to compare
    ]  # fmt: skip
    shown += ["reference"] if evidence.reference else []
    figures = [f"![{TITLES[name]}]({name}.svg)\n" for name in shown]
    about = (
        "Thin lines are seeds, on a few starts at each evaluation; the thick line is their "
        "interquartile mean, the band its bootstrap interval over seeds. Right of each panel are "
        "the final held-out rates. BC+RNN learns from the source's demonstrations alone.\n"
    )
    return "\n".join(["## Learning\n", about, *figures])


def _methods(evidence: Evidence) -> str:
    parts = []
    for transfer, task in TASKS.items():
        parts.append(f"### {task}\n\n{methods_table(summaries(evidence, [transfer]))}")
    return "\n".join(parts)


def _stages(evidence: Evidence) -> str:
    if not evidence.stages:
        return "No stage has been run yet."
    missing = [stage for stage in STAGES if stage not in evidence.stages]
    lines = [
        f"All stages together took {hours(evidence):.2f} hours by the clock, one after the other; "
        f"{time_of_tables(evidence)}. The main job's demonstrations and datasets are not counted. "
        "A stage or a run that was killed counts from where it went on, and a stage that was run "
        "again only what it had not finished before.",
        *([f"Nothing is there yet of: {', '.join(missing)}."] if missing else []),
        time_of_runs(evidence),
    ]
    about = (
        "Of the last run of every job of a stage: the wall-clock, summed; the peak "
        "memory of the largest process; the git revisions, with a plus sign where the sources "
        "differed from what was committed."
    )
    return "\n\n".join([" ".join(lines), about, stage_table(evidence.stages)]).rstrip()


def _demoted(text: str) -> str:
    """Its headings one level further down."""
    return re.sub(r"^#", "##", text, flags=re.MULTILINE)
