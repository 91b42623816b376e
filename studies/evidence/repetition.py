"""One repetition of one transfer: the jobs that train, learn and judge, and the runs they give."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from lfr.artifacts import fingerprint
from lfr.embodiments import embodiment
from lfr.evaluation.chain import chain_trials
from lfr.evaluation.trials import JudgeName, Trial, success_rate, trial_jobs
from lfr.jobs import Job
from lfr.mapping.mapped_policy import MappedFiles
from lfr.mapping.mapping_jobs import fit_mapping, mapping_job
from lfr.policies import PolicySource
from lfr.scenarios import Role, Scenario, Transfer
from lfr.skills.library import RoleModels, transfer_models
from lfr.skills.skill_policy import SkillFiles
from studies.evidence.evidence_params import OURS, Asked, Setting
from studies.evidence.runs import CurvePoint, Run
from studies.imitation.cloning import ImitationJob, fit_imitation
from studies.imitation.saved_policies import RecurrentPolicyFiles
from studies.learning import LearningJob, learn
from studies.methods import BaselineFiles
from studies.spirl.any_task import AnyTaskJob, fit_any_task

IMITATION = "bc_rnn"
WITH_G = ("lfr",)  # methods that learn from a mapping
LINKS = {"mapped": "lfr"}  # what the table calls a link, where it is what a method begins with


@dataclass(frozen=True)
class Measured:
    """A policy, the jobs that judge it, and the one that made it."""

    method: str
    option: str
    trial: Trial
    shards: list[Job]
    learning: Job | None = None

    @property
    def jobs(self) -> list[Job]:
        return [*([self.learning] if self.learning else []), *self.shards]


@dataclass(frozen=True)
class Repetition:
    """A seed of a transfer in a setting.

    Attributes:
        root: of everything that this number of demonstrations gives.
    """

    asked: Asked
    setting: Setting
    scenario: Scenario
    transfer: Transfer
    seed: int
    root: Path

    @property
    def datasets(self) -> Path:
        return self.root / "datasets"

    @property
    def folder(self) -> Path:
        return self.root / f"seed-{self.seed}"

    @cached_property
    def skills(self) -> dict[Role, RoleModels]:
        return transfer_models(self.scenario, self.transfer, self.folder / "skills")

    def measured(self) -> Iterator[Measured]:
        """All that the setting asks for, in the order in which it is to be run."""
        setting = self.setting
        if setting.links:
            yield from self._links()
        for option in setting.options:
            yield self._mapped(option)
        if IMITATION in setting.methods:
            yield self._imitation()
        for method in setting.methods:
            if method != IMITATION:
                yield from self._learned(method, OURS if method in WITH_G else "")
        for option in setting.learned:
            yield from self._learned("lfr", option)

    def runs(
        self, measured: Measured, done: Mapping[Job, Any], made_by: Mapping[str, Any]
    ) -> tuple[Run, list[CurvePoint]]:
        """What a policy has come to, by the results of its jobs, and its curve."""
        transfer, trial = self.transfer, measured.trial
        found = success_rate(measured.shards, done)
        course = done[measured.learning] if measured.learning else {}
        source, target = embodiment(transfer.source), embodiment(transfer.target)
        known = {
            "transfer": transfer.name,
            "method": measured.method,
            "option": measured.option,
            "reward": self.setting.reward if "env_steps" in course else "",
            "demonstrations": self.asked.record_params(self.setting).episodes,
            "seed": self.seed,
        }
        run = Run(
            **known,
            task=transfer.task,
            source=source.robot.name,
            source_controller=source.controller.name,
            target=target.robot.name,
            target_controller=target.controller.name,
            env_steps=course.get("env_steps", 0),
            starts=found["episodes"],
            successes=found["successes"],
            judge=trial.judge,
            revision=made_by["revision"] + "+" * bool(made_by["modified"]),
            processor=made_by["processor"] or "",
            seconds=round(course["seconds"], 1) if course else None,
            outcomes=found["outcomes"],
        )
        points = [
            CurvePoint(**known, env_steps=point["env_steps"], success=point["success"])
            for point in course.get("curve", ())
        ]
        return run, points

    def _links(self) -> Iterator[Measured]:
        task, skills, mapping = self.transfer.task, self.skills, self._mapping(OURS)
        trials = chain_trials(self.transfer, skills, self._mapping_folder(OURS), self._episodes)
        source = SkillFiles(str(skills["source"].prior(task)), str(skills["source"].vae()))
        trials["own_arm"] = Trial(source, self.transfer.source, task, self._episodes)
        if "oracle" in skills:
            oracle = SkillFiles(str(skills["oracle"].prior(task)), str(skills["oracle"].vae()))
            trials["oracle"] = Trial(oracle, self.transfer.target, task, self._episodes)
        for link, trial in trials.items():
            needs = (mapping,) if link in ("linear", "mapped") else ()
            option = OURS if link in ("linear", "mapped") else ""
            yield Measured(LINKS.get(link, link), option, trial, trial_jobs(trial, needs))

    def _mapped(self, option: str) -> Measured:
        """G as an option has it, before any learning."""
        prior = str(self.skills["source"].prior(self.transfer.task))
        g = str(self._mapping_folder(option) / "g")
        trial = self._on_target(MappedFiles(prior, g, str(self.skills["target"].vae())))
        return Measured("lfr", option, trial, trial_jobs(trial, (self._mapping(option),)))

    def _imitation(self) -> Measured:
        transfer, folder = self.transfer, self.folder / IMITATION / self.transfer.name
        job = Job(
            fit_imitation,
            ImitationJob(
                self.scenario, transfer.source, transfer.task, self.asked.imitation,
                self.asked.skills.held_out, self.seed, str(folder), str(self.datasets),
            ),
        )  # fmt: skip
        trial = self._on_target(RecurrentPolicyFiles(str(folder)))
        return Measured(IMITATION, "", trial, trial_jobs(trial, (job,)), job)

    def _learned(self, method: str, option: str) -> Iterator[Measured]:
        params = self.asked.transfer_params(method, self.setting.reward)
        mapping = self._mapping(option) if option else None
        name = "-".join(filter(None, (method, option, fingerprint(params)[:8])))
        folder = self.folder / "learned" / self.transfer.name / name
        needs = [job for job in (mapping, self._spirl if method == "spirl" else None) if job]
        learning = Job(
            learn,
            LearningJob(
                self.transfer, method, self.seed, params, str(folder), self.skills,
                str(self._mapping_folder(option or OURS)), self._spirl_folder,
            ),
            tuple(needs),
        )  # fmt: skip
        retargeted = self.transfer.source if method == "retarget" else None
        files = BaselineFiles(str(folder / "policy"), retargeted)
        judges: list[tuple[JudgeName, int]] = [("engine", self._episodes)]
        if method in self.setting.stock and option in ("", OURS):
            judges.append(("robosuite", self.asked.stock_episodes))
        for judge, episodes in judges:
            trial = replace(self._on_target(files), judge=judge, episodes=episodes)
            yield Measured(method, option, trial, trial_jobs(trial, (learning,)), learning)

    def _mapping(self, option: str) -> Job:
        if option not in self._mappings:
            chosen = self.asked.options[option]
            common = chosen.common or self.transfer.common
            spec = mapping_job(
                self.scenario, replace(self.transfer, common=common),
                self.asked.mapping_params(option), self.asked.skills.held_out, self.seed,
                self.skills, self._mapping_folder(option), self.datasets,
            )  # fmt: skip
            self._mappings[option] = Job(fit_mapping, spec)
        return self._mappings[option]

    @cached_property
    def _mappings(self) -> dict[str, Job]:
        return {}

    def _mapping_folder(self, option: str) -> Path:
        content = fingerprint(self.asked.mapping_params(option), self.asked.options[option].common)
        return self.folder / "mapping" / self.transfer.name / f"{option}-{content[:8]}"

    @cached_property
    def _spirl(self) -> Job:
        spec = AnyTaskJob(
            self.scenario, self.transfer, self.asked.skills.prior, self.asked.skills.held_out,
            self.seed, self.skills["target"], str(Path(self._spirl_folder).parent),
            str(self.datasets),
        )  # fmt: skip
        return Job(fit_any_task, spec)

    @property
    def _spirl_folder(self) -> str:
        return str(self.folder / "spirl" / self.transfer.name / "prior")

    @property
    def _episodes(self) -> int:
        return self.asked.episodes

    def _on_target(self, policy: PolicySource) -> Trial:
        return Trial(policy, self.transfer.target, self.transfer.task, self._episodes)
