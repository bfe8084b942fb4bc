"""Sessions that begin shortly before a behavior went wrong in a failing world, so that a press can correct it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from understudy.addons.checks.falsification.failing_world import FailingWorld, read_failing_world
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.errors import SessionError, UnknownName
from understudy.judging.evaluate import find_runners
from understudy.judging.rerun import WorldRerun, find_traced_run
from understudy.judging.tracing import AgentRef
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.runtime.interpreter import Interpreter, StackFrame
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.runtime.team.squad_body import SquadBody
from understudy.sim.scenario.files import add_markers
from understudy.sim.team.libraries import Libraries, collect_libraries, list_running_sorts
from understudy.sim.world import World
from understudy.training.other_agents import RunStates, SessionSnapshot
from understudy.training.session import Session
from understudy.training.trainee import Mode

BEFORE_S = 3.0
"""The time before the failure at which a session begins by default, s."""

AFTER_S = 1.0
"""The time after the end of progress at which the innermost automaton is taken for the one that made the mistake, s."""


@dataclass(frozen=True, slots=True)
class TeachingMoment:
    """A moment of a run at which a session of one of the automata that run then can begin, to correct it.

    `world` is the world then, with markers to place by hand. `body` is what the session trains on, the world or the
    coordinators of a sort of squads, and `agent` the robot or coordinator. `name` is the automaton to correct, `lesson`
    its lesson, `library` the library that it is in, `targets` are those of its parameters, and `states` is its run
    state and that of the automata below it, empty before the first decision. `behavior` with `binding` is what the
    other agents of the body run. In a team `members` are the robots' interpreters, which go on with their last orders
    where a robot is corrected. `others` are the run states of all agents of the body; None: they restart.
    """

    world: World
    body: World | CoordinatorBody
    agent: int
    name: str
    lesson: Lesson
    library: Library
    targets: Mapping[str, str]
    states: tuple[StackFrame, ...]
    behavior: str
    binding: Mapping[str, str]
    members: Sequence[Interpreter] = ()
    others: RunStates | None = None

    @property
    def sort(self) -> str | None:
        """The sort of squads whose coordinator is corrected; None if it is a robot."""
        return self.body.squads.squad.name if isinstance(self.body, CoordinatorBody) else None

    def open_session(self) -> Session:
        """Open a session of the automaton on the body of this moment, which goes on from here."""
        session = Session(self.body, self.library, self.lesson, targets=self.targets, agent=self.agent)
        self.restore_in(session)
        return session

    def restore_in(self, session: Session) -> None:
        """Continue the run of this moment in a session of the automaton, on the body of this moment."""
        if self.members:
            session.other_agents.take_over(self.members)
        elif self.body.agents > 1:
            session.other_agents.set_behavior(self.behavior, self.binding)
        session.teach()
        if not self.states:
            session.other_agents.start()
            return
        others = session.other_agents.snapshot() if self.others is None else self.others
        session.rewind(SessionSnapshot(self.body.snapshot(), self.states, Mode.LIVE, others))


class RunInstant(NamedTuple):
    """An instant of a run: the body, the automata that an agent runs, the root first, with their targets and states.

    `members` and `others` are those of `TeachingMoment`.
    """

    body: bytes
    active: Sequence[tuple[str, Mapping[str, str]]]
    states: tuple[StackFrame, ...]
    members: Sequence[Interpreter] = ()
    others: RunStates | None = None


class _Post(NamedTuple):
    """An agent that can be corrected, and the body on which a session trains it."""

    body: World | CoordinatorBody
    agent: AgentRef

    def note_instant(self) -> RunInstant:
        """Note the present instant of the run, with the run states of all agents of the body."""
        interpreters, now = find_traced_run(self.agent).interpreters, self.body.time_s
        driver = interpreters[self.agent.agent]
        active = [(each.automaton.name, each.instance.binding) for each in driver.active]
        others = tuple(each.snapshot(now) for each in interpreters)
        members = tuple(interpreters) if isinstance(self.body, World) else ()
        return RunInstant(self.body.snapshot(), active, others[self.agent.agent], members, others)


def _list_posts(rerun: WorldRerun, robot: int, *, is_led: bool) -> list[_Post]:
    """List the agents that can be corrected: a robot, and the topmost coordinator above it if coordinators lead."""
    chain = rerun.list_chain(robot)
    posts = [_Post(rerun.world, chain[-1])]
    if is_led and isinstance(chain[0].layer.body, SquadBody):
        posts.append(_Post(CoordinatorBody(rerun.team, chain[0].sort), chain[0]))
    return posts


def _choose_post(
    instants_of: Sequence[Sequence[RunInstant]],
    libraries: Sequence[Library],
    between: Sequence[Library],
    name: str | None,
) -> int:
    """Return the number of the agent whose automaton is corrected: the robot, or the topmost coordinator.

    `instants_of` and `libraries` are theirs, and `between` has the libraries of coordinators between them.
    """
    ends = [instants[-1].active for instants in instants_of]
    if name is None:
        for number, active in enumerate(ends):
            if any(libraries[number].taught[each].lesson is not None for each, _ in active):
                return number
        return next((number for number, active in enumerate(ends) if active), 0)
    for number, instants in enumerate(instants_of):
        if any(name == each for instant in instants for each, _ in instant.active):
            return number
    if any(name in each.taught for each in between):
        raise SessionError(
            f"{name!r} is that of a coordinator below another one, which cannot be trained in its team: name an "
            "automaton of the robot or of the topmost coordinator"
        )
    names = [each for active in ends for each, _ in active]
    raise UnknownName(what="automaton", name=name, where="the run at this moment", known=names)


def _choose_instant(
    instants: Sequence[RunInstant], library: Library, name: str | None
) -> tuple[RunInstant, int]:
    """Return the instant at which to begin, and the level of the automaton to correct.

    Without a name that automaton is the innermost one with a lesson in the end, and it begins as soon as it runs
    without a break until then; else as soon as the automaton of that name runs.
    """
    end = instants[-1].active
    if not any(instant.active for instant in instants):
        raise SessionError("it runs no automaton at this moment: there is nothing to correct")
    if name is not None:
        for instant in instants:
            names = [each for each, _ in instant.active]
            if name in names:
                return instant, names.index(name)
        names_at_end = [each for each, _ in end]
        raise UnknownName(what="automaton", name=name, where="the run at this moment", known=names_at_end)
    taught = [level for level, (each, _) in enumerate(end) if library.taught[each].lesson is not None]
    level = taught[-1] if taught else len(end) - 1
    began = len(instants) - 1
    while began and instants[began - 1].active[: level + 1] == end[: level + 1]:
        began -= 1
    return instants[began], level


def open_failure(
    failing: FailingWorld | Path | str,
    library: Library | Libraries,
    *,
    name: str | None = None,
    before_s: float = BEFORE_S,
) -> Session:
    """Open a live session some seconds before a behavior went wrong in a failing world.

    The robot runs as it ran in the search until then, and the session goes on from there with one of the automata that
    were running. A press corrects it; `save_automaton` keeps it. Other robots restart the behavior. In a team, where a
    coordinator is corrected all agents go on as they were; where a robot is, the other robots go on with their last
    orders, and coordinators give no further ones.

    Parameters
    ----------
    failing
        The failing world, or its folder.
    library
        The library with the behavior, and with the lesson to correct; or for a team the library of each sort of agents.
    name
        Name of the automaton to correct. None: the innermost one with a lesson that ran when it went wrong.
    before_s
        How long before the failure it begins, s; later if the run, or that automaton, began later.

    Returns
    -------
    Session
        The session. Nothing has been recorded.

    Raises
    ------
    FileError
        If the folder does not have a failing world.
    UnknownName
        If the library does not have the behavior, or no automaton of that name ran then.
    SessionError
        If the automaton has no lesson, or is that of a coordinator below another one.
    """
    world = failing if isinstance(failing, FailingWorld) else read_failing_world(failing)
    return find_failure_moment(world, library, name=name, before_s=before_s).open_session()


def find_failure_moment(
    failing: FailingWorld,
    library: Library | Libraries,
    *,
    name: str | None = None,
    before_s: float = BEFORE_S,
    wrong_s: float | None = None,
) -> TeachingMoment:
    """Run a failing world until some seconds before the behavior goes wrong.

    Parameters
    ----------
    failing
        The failing world.
    library
        The library with the behavior, and with the lesson to correct; or for a team the library of each sort of agents.
    name
        Name of the automaton to correct. None: the innermost one with a lesson that ran when it went wrong.
    before_s
        How long before the failure, s; later if the run, or that automaton, began later.
    wrong_s
        When it goes wrong, s. None: as it was kept.

    Returns
    -------
    TeachingMoment
        The moment.

    Raises
    ------
    UnknownName
        If the library does not have the behavior, or no automaton of that name ran then.
    SessionError
        If the automaton has no lesson, or is that of a coordinator below another one.
    """
    facts = failing.facts
    return find_moment(
        failing.trial,
        library,
        facts.behavior,
        binding=facts.binding,
        wrong_s=facts.wrong_s if wrong_s is None else wrong_s,
        before_s=before_s,
        after_s=AFTER_S if facts.property is None else 0.0,
        robot=facts.robot,
        name=name,
    )


def find_moment(
    trial: Trial,
    library: Library | Libraries,
    behavior: str,
    *,
    binding: Mapping[str, str],
    wrong_s: float,
    before_s: float = BEFORE_S,
    after_s: float = AFTER_S,
    robot: int = 0,
    name: str | None = None,
) -> TeachingMoment:
    """Run a behavior in a world until some seconds before it goes wrong.

    Parameters
    ----------
    trial
        The world.
    library
        The library with the behavior, and with the lesson to correct; or for a team the library of each sort of agents.
    behavior
        Name of the behavior, in a team with the sort of agents before it or without.
    binding
        The target of each parameter.
    wrong_s
        When it goes wrong, s.
    before_s
        How long before that, s; later if the run, or that automaton, began later.
    after_s
        How long after that the innermost automaton is taken for the one that made the mistake, s.
    robot
        The robot to correct.
    name
        Name of the automaton to correct. None: the innermost one with a lesson, the robot's before its coordinator's.

    Returns
    -------
    TeachingMoment
        The moment.

    Raises
    ------
    UnknownName
        If the library does not have the behavior, or no automaton of that name ran then.
    SessionError
        If the automaton has no lesson, or is that of a coordinator below another one.
    """
    scenario = add_markers(trial.scenario)
    ticks, until = round((wrong_s - before_s) / scenario.tick_s), round((wrong_s + after_s) / scenario.tick_s)
    libraries, sort, root, own = find_runners(library, behavior, scenario)
    is_led = sort is not None
    if sort is None or isinstance(libraries, Library):
        libraries, sorts = collect_libraries(scenario, own), [*scenario.types]
    else:
        sorts = list_running_sorts(libraries, sort, root)
    rerun = WorldRerun(scenario, trial.seed, libraries, dict.fromkeys(sorts, (root, binding)))
    posts = _list_posts(rerun, robot, is_led=is_led)
    starts = [post.body.snapshot() for post in posts]
    first = max(1, ticks)
    rerun.replay_to(first - 1)
    noted = list[list[RunInstant]]()
    rerun.replay_to(max(first, until), lambda: noted.append([post.note_instant() for post in posts]))
    instants_of = [[each[number] for each in noted] for number in range(len(posts))]
    between = [libraries[each.sort] for each in rerun.list_chain(robot)[1:-1]] if is_led else []
    number = _choose_post(instants_of, [libraries[post.agent.sort] for post in posts], between, name)
    post, instants, of_agent = posts[number], instants_of[number], libraries[posts[number].agent.sort]
    instant, level = _choose_instant(instants, of_agent, name)
    automaton, targets = instant.active[level]
    lesson = of_agent.taught[automaton].lesson
    if lesson is None:
        raise SessionError(f"{automaton!r} has no lesson: nothing was recorded when it was made")
    is_start = ticks < 1 and instant is instants[0]
    post.body.restore(starts[number] if is_start else instant.body)
    return TeachingMoment(
        rerun.world,
        post.body,
        post.agent.agent,
        automaton,
        lesson,
        of_agent,
        targets,
        () if is_start else instant.states[level:],
        behavior.removeprefix(f"{post.agent.sort}/"),
        binding,
        instant.members if is_led else (),
        instant.others if is_led else None,
    )
