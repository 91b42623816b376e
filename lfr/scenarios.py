"""Which arm knows which task, what is transferred to whom, and who may see what.

The rule of the experiment stands here alone: a target arm's models see the common tasks only. Its
demonstrations of the new task reach nothing but the oracle.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

from lfr.embodiments import embodiments, is_known
from lfr.errors import LfrError, ParameterError, UnknownNameError
from lfr.external import ExternalArm, external
from lfr.params import PARAMS, read_yaml
from lfr.records import from_mapping
from lfr.tasks import TASKS
from lfr.tasks import task as task_named

Role = Literal["source", "target", "oracle"]
ROLES: tuple[Role, ...] = get_args(Role)


@dataclass(frozen=True)
class Scenario:
    """Two arms that share some tasks, each with one new task that the other one teaches it.

    Attributes:
        name: as in params.yaml, e.g. "s1".
        common: tasks that both arms have demonstrations of.
        new: robot -> the task that it learns.
        arms: the two arms, where `new` names but one of them.
        undemonstrated: robots that have no demonstrations of their own new task, so no oracle.
    """

    name: str
    common: tuple[str, ...]
    new: dict[str, str]
    arms: tuple[str, ...] = ()
    undemonstrated: tuple[str, ...] = ()

    @property
    def robots(self) -> tuple[str, str]:
        """The two arms, in the order of `new`, or of `arms` where that is given."""
        first, second = self.arms or self.new
        return first, second

    def other(self, robot: str) -> str:
        """The arm beside ``robot``.

        Raises:
            UnknownNameError: the robot is not in this scenario.
        """
        first, second = self.robots
        if robot not in self.robots:
            raise UnknownNameError(f"robot of scenario {self.name}", robot, self.robots)
        return second if robot == first else first


@dataclass(frozen=True)
class Transfer:
    """One new task that goes from the arm that knows it to the one that does not.

    Attributes:
        name: ``<scenario>-<target>-<task>``, e.g. "s1-panda-lift".
        scenario: name of the scenario.
        source: the arm with demonstrations of the new task.
        target: the arm that learns it.
        common: tasks that both arms have demonstrations of.
        task: the new task.
        oracle: whether the target has demonstrations of the new task too, for comparison alone.
    """

    name: str
    scenario: str
    source: str
    target: str
    common: tuple[str, ...]
    task: str
    oracle: bool = True


@dataclass(frozen=True)
class _Entry:
    """A scenario as params.yaml writes it."""

    common: tuple[str, ...]
    new: dict[str, str]
    arms: tuple[str, ...] = ()


def scenarios(path: Path = PARAMS) -> dict[str, Scenario]:
    """The scenarios of params.yaml, by name, those of external arms after the others.

    Raises:
        ParameterError: one is incomplete or contradicts itself.
        UnknownNameError: it names an unknown robot or task.
    """
    section = read_yaml(path).get("scenarios")
    theirs = external(path)
    if not isinstance(section, dict) or not (section or theirs.scenarios):
        raise ParameterError(f"{path}: no section 'scenarios'")
    twice = sorted(set(section) & set(theirs.scenarios))
    if twice:
        raise ParameterError(f"{path}: {', '.join(twice)} under 'scenarios' and under 'external'")
    places = (("scenarios", section), ("external.scenarios", theirs.scenarios))
    return {
        str(name): _scenario(str(name), entry, f"{path}: {place}.{name}", theirs.arms)
        for place, entries in places
        for name, entry in entries.items()
    }


def scenario(name: str, path: Path = PARAMS) -> Scenario:
    """The scenario called ``name``.

    Raises:
        UnknownNameError: there is none; the message lists those there are.
    """
    known = scenarios(path)
    if name not in known:
        raise UnknownNameError("scenario", name, known)
    return known[name]


def transfers(path: Path = PARAMS) -> dict[str, Transfer]:
    """The transfers of all scenarios, by name: two of each, one per arm."""
    return {
        transfer.name: transfer
        for known in scenarios(path).values()
        for transfer in transfers_of(known)
    }


def transfer(name: str, path: Path = PARAMS) -> Transfer:
    """The transfer called ``name``.

    Raises:
        UnknownNameError: there is none; the message lists those there are.
    """
    known = transfers(path)
    if name not in known:
        raise UnknownNameError("transfer", name, known)
    return known[name]


def transfers_of(scenario: Scenario) -> tuple[Transfer, ...]:
    """What the arms of a scenario learn from each other."""
    return tuple(
        Transfer(
            name=f"{scenario.name}-{target}-{task}",
            scenario=scenario.name,
            source=scenario.other(target),
            target=target,
            common=scenario.common,
            task=task,
            oracle=target not in scenario.undemonstrated,
        )
        for target, task in scenario.new.items()
    )


def visible_tasks(scenario: Scenario, robot: str, role: Role) -> tuple[str, ...]:
    """The tasks whose demonstrations by ``robot`` a model may see.

    - "source": the common tasks and the other arm's new task, which this arm teaches;
    - "target": the common tasks alone;
    - "oracle": the common tasks and the arm's own new task, as if it had been demonstrated.

    Raises:
        UnknownNameError: the robot is not in the scenario, or there is no such role.
    """
    other = scenario.other(robot)
    match role:
        case "source":
            return (*scenario.common, *_new(scenario, other))
        case "target":
            return scenario.common
        case "oracle":
            return (*scenario.common, *_new(scenario, robot))
    raise UnknownNameError("role", role, ROLES)


def check_visible(scenario: Scenario, robot: str, role: Role, tasks: Iterable[str]) -> None:
    """Hold the rule where demonstrations are read or a model that has seen them is used.

    Raises:
        LfrError: one of ``tasks`` is hidden from this robot in this role.
    """
    visible = visible_tasks(scenario, robot, role)
    for task in tasks:
        if task not in visible:
            raise LfrError(
                f"demonstrations of {task!r} by {robot} are hidden from a model in role {role!r} "
                f"of scenario {scenario.name}; visible: {', '.join(visible)}"
            )


def _new(scenario: Scenario, robot: str) -> tuple[str, ...]:
    return (scenario.new[robot],) if robot in scenario.new else ()


def _scenario(name: str, entry: object, where: str, arms: Mapping[str, ExternalArm]) -> Scenario:
    read = from_mapping(_Entry, entry, where)
    robots = read.arms or tuple(read.new)
    for robot in (*read.new, *robots):
        if robot not in arms and not is_known(robot):
            simulated = (body.name for body in embodiments())
            raise UnknownNameError("robot", robot, (*simulated, *arms))
    if len(set(robots)) != 2 or len(robots) != 2:
        kind = "arms" if read.arms else "new"
        raise ParameterError(f"{where}: found {len(robots)} robots under {kind!r}, expected two")
    if not read.new or not set(read.new) <= set(robots):
        raise ParameterError(
            f"{where}: found {', '.join(read.new) or 'no robot'} under 'new', "
            f"expected one of {', '.join(robots)} or both"
        )
    tasks = (*read.common, *read.new.values())
    if not read.common:
        raise ParameterError(f"{where}: 'common' names no task; G and F are learned on these")
    twice = sorted({task for task in tasks if tasks.count(task) > 1})
    if twice:
        raise ParameterError(
            f"{where}: {', '.join(twice)} named twice; a task is common or new to one robot"
        )
    for robot in robots:
        taught = [task for target, task in read.new.items() if target != robot]
        for task in (*read.common, *taught):
            if robot not in arms:
                task_named(task)
            elif task not in arms[robot].tasks:
                raise UnknownNameError(f"task of {robot}", task, arms[robot].tasks)
    undemonstrated = tuple(
        robot
        for robot, task in read.new.items()
        if task not in (arms[robot].tasks if robot in arms else TASKS)
    )
    return Scenario(name, read.common, read.new, read.arms, undemonstrated)
