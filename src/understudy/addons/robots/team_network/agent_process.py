"""One agent of a team in a process of its own: a robot, a coordinator, or a robot that may lead its squad, too."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import ExitStack
from functools import partial
from math import inf
from pathlib import Path
from queue import Empty, Queue
from threading import Event
from typing import Protocol

import msgspec

from understudy.addons.robots.fleet import Fleet, connect_robot
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.ros.diagnostic_messages import DiagnosticStatus, StatusLevel
from understudy.addons.robots.team_network.agent_claim import claim_name
from understudy.addons.robots.team_network.agent_questions import AgentAnswer, AgentQuestion, AgentStatus
from understudy.addons.robots.team_network.agent_recorder import AgentRecorder, RecordedNetwork
from understudy.addons.robots.team_network.agent_views import STATUS, STATUS_S, RobotViews, is_watched
from understudy.addons.robots.team_network.arming_permits import ArmingPermits
from understudy.addons.robots.team_network.library_push import LibraryFolder
from understudy.addons.robots.team_network.load_plan import LoadedTeam, fingerprint_folder
from understudy.addons.robots.team_network.team_access import TeamAccess
from understudy.addons.robots.twin import DigitalTwin
from understudy.clock import REAL_TIME, Clock
from understudy.errors import UnderstudyError, UnknownName
from understudy.model.binding import Binding
from understudy.model.squad import Assignment
from understudy.records.recorder import RunRecorder
from understudy.runtime.agents.agent import Agent
from understudy.runtime.agents.coordinator import SquadCoordinator
from understudy.runtime.agents.messages import UNREADABLE
from understudy.runtime.agents.network import Network
from understudy.runtime.agents.remote_members import TickClock

LOOK_S = 0.005
"""The time between two looks at a simulation's clock, s."""
LOGGED = 500
"""The number of lines of an agent's log that are kept."""
ANSWER_S = 2.0
"""The longest time in s that a command waits for the agent to carry it out."""


class WallClock:
    """The clock of a coordinator without a robot.

    Parameters
    ----------
    tick_s
        The nominal length of a tick, s.
    targets
        The targets of the team.
    clock
        A monotonic clock, s.
    """

    def __init__(self, tick_s: float, targets: Sequence[str], clock: Callable[[], float] = REAL_TIME) -> None:
        self.tick_s, self.targets, self._clock = tick_s, tuple(targets), clock
        self._began = clock()
        self.time_s = 0.0

    def advance(self) -> None:
        """Take the present time as that of this tick."""
        self.time_s = self._clock() - self._began


class ConnectRobot(Protocol):
    """A function that connects to the robot of a robot file as a fleet of one, optionally with a recorder."""

    def __call__(self, path: Path, *, recorder: RunRecorder | None) -> Fleet:
        """Connect to the robot of a file."""
        ...


class AgentProcess:
    """The agent of this process.

    Parameters
    ----------
    name
        The name of the agent: a robot's, or that of a squad.
    team
        The team.
    network
        Its access to the network.
    record
        The recorder of a file in which it is recorded; None: it is not.
    clock
        The clock of its leases, permits and ticks; ticks go by a simulation's clock if its robot does.
    connect
        A function that connects to its robot.

    Raises
    ------
    UnknownName
        If the team has no agent of this name.
    SettingError
        If an agent of this name is running elsewhere.
    """

    def __init__(
        self,
        name: str,
        team: LoadedTeam,
        network: TeamAccess,
        *,
        record: RunRecorder | None = None,
        clock: Clock = REAL_TIME,
        connect: ConnectRobot = connect_robot,
    ) -> None:
        if name not in team.agents:
            raise UnknownName(what="agent", name=name, where=f"team {team.name}", known=list(team.agents))
        claim_name(network, name, team=team.name, clock=clock)
        self.name, self.team, self._network, self._clock = name, team, network, clock
        self._recorder = None if record is None else AgentRecorder(record, name, team)
        self._messages: Network = network if record is None else RecordedNetwork(network, record, name)
        self._exit = ExitStack()
        self._log: deque[str] = deque(maxlen=LOGGED)
        self._asked: Queue[tuple[AgentQuestion, Future[AgentAnswer]]] = Queue()
        self._permits = ArmingPermits(clock)
        self.ticks = self.late = 0
        self.left = False
        """Whether the agent was told to leave."""
        self.restarts = False
        """Whether the agent has to restart, with another library."""
        self._library = LibraryFolder(team.library, name, partial(fingerprint_folder, team.scenario))
        self.robot: Robot | None = None
        self._pace: Callable[[], float] = clock
        self.agent: Agent | None = None
        self._tick_clock: TickClock | WallClock = WallClock(team.scenario.tick_s, team.plan.targets, clock)
        if name in team.robots:
            self._connect_robot(team.robots[name][1], connect)
        self.coordinators = [
            SquadCoordinator(
                team.plan.make_agent_spec(squad),
                team.plan.make_squad_spec(squad),
                host=name,
                candidates=team.plan.list_candidates(squad),
                clock=self._tick_clock,
                network=self._messages,
                lease_clock=clock,
            )
            for squad in team.plan.list_led_squads(name)
        ]
        self._was_leading: dict[str, bool] = {}
        robot: Robot | None = self.robot
        self._views = None if robot is None else RobotViews(robot, network)
        self._told_s = -inf
        network.answer(f"agent/{name}", self._answer)
        network.announce(name)
        self.note("started")

    def _connect_robot(self, path: Path, connect: ConnectRobot) -> None:
        recorder = self._recorder
        file = None if recorder is None else recorder.recorder
        fleet = connect(path, recorder=file)
        self._exit.callback(fleet.close)
        twin = DigitalTwin(fleet, recorder=file)
        self.robot = robot = fleet.robots[0]
        self._pace = robot.simulation_clock or self._clock
        if robot.simulation_clock is None:
            self._tick_clock = twin
        self.agent = Agent(
            self.team.plan.make_agent_spec(self.name),
            twin,
            self._messages,
            unfit=lambda: robot.unfitness,
            clock=self._clock,
        )
        twin.follow(self._list_paths)
        if recorder is not None:
            twin.record(recorder.describe_run(self.name))
            recorder.follow_robot(self.agent, robot.file.namespace or robot.file.name)
        if robot.status_publisher is not None:
            robot.status_publisher.parts.append(self._describe_diagnostics)

    def _describe_diagnostics(self) -> DiagnosticStatus:
        """Describe the agent for its robot's diagnostics: WARN while no order holds."""
        status = self.describe()
        level = StatusLevel.WARN if status.order is None else StatusLevel.OK
        message = "is alone: no order holds" if status.order is None else f"obeys {status.leader}"
        values = {
            "order": "" if status.order is None else f"{status.order[0]}.{status.order[1]}",
            "duty": status.duty,
            "state": " > ".join(status.path),
            "leads": ", ".join(status.leads),
            "late ticks": str(status.late),
            "refused orders": str(sum(status.refused.values())),
        }
        return DiagnosticStatus(f"understudy agent: {self.name}", level, message, values)

    def _list_paths(self) -> list[tuple[str, ...]]:
        return [] if self.agent is None else [self.agent.path]

    # Ticks

    def tick(self) -> None:
        """Hear, sense and report, decide and act once, and carry out what was asked."""
        if isinstance(self._tick_clock, WallClock):
            self._tick_clock.advance()
        if self.agent is not None:
            self.agent.sense()
            self.agent.report()
            if self._views is not None and is_watched(self._network):
                self._views.publish()
        for coordinator in self.coordinators:
            coordinator.sense()
            coordinator.report()
        for coordinator in reversed(self.coordinators):
            if self._recorder is not None:
                self._recorder.note_squad(coordinator)
            coordinator.obey()
            if self._recorder is not None:
                self._recorder.note_squad(coordinator)
            coordinator.act()
            if self._recorder is not None:
                self._recorder.write_squad_tick(coordinator)
            self._note_leading(coordinator)
        if self.agent is not None:
            before = self._describe_duty(self.agent)
            self.agent.obey()
            if self._recorder is not None:
                self._recorder.note_beginning()
            self.agent.act()
            if (duty := self._describe_duty(self.agent)) != before:
                self.note(f"runs {duty}" if duty else "is alone: no order holds any more")
        self.ticks += 1
        self._tell_viewers()
        self._carry_out()

    def _tell_viewers(self) -> None:
        """Publish this agent's status from time to time, while a computer watches the team."""
        now = self._clock()
        if now - self._told_s >= STATUS_S and is_watched(self._network):
            self._told_s = now
            self._network.publish(f"{STATUS}/{self.name}", msgspec.msgpack.encode(self.describe()))

    def run(self, *, until: Callable[[], bool] = lambda: False) -> None:
        """Tick at the team's rate until the agent is told to leave, or `until` says so."""
        due_s = self._pace()
        while not self.left and not until():
            due_s = self.step(due_s)
            if self._pace is self._clock:
                self._clock.sleep(due_s - self._clock())
            else:
                self._wait(due_s, until)

    def step(self, due_s: float) -> float:
        """Tick once, and return when the next tick is due: at once if this one was late, which is counted.

        Parameters
        ----------
        due_s
            When this tick was due, s by the clock of its ticks.

        Returns
        -------
        float
            When the next one is, s.
        """
        self.tick()
        due_s += self.team.scenario.tick_s
        if (now := self._pace()) < due_s:
            return due_s
        self.late += 1
        return now

    def _wait(self, due_s: float, until: Callable[[], bool]) -> None:
        """Wait for a simulation's clock, which may stand still, and answer questions meanwhile."""
        while self._pace() < due_s and not self.left and not until():
            self._clock.sleep(LOOK_S)
            self._carry_out()

    def close(self) -> None:
        """Stop the robot and leave the network."""
        self._exit.close()
        self._network.close()

    # Questions

    def note(self, line: str) -> None:
        """Write a line to the log of this agent."""
        self._log.append(f"{_stamp()} {self.name} {line}")

    def _note_leading(self, coordinator: SquadCoordinator) -> None:
        squad, leads = coordinator.spec.name, coordinator.leads
        if self._was_leading.get(squad, False) != leads:
            term = coordinator.leadership.term
            self.note(f"leads {squad} in term {term}" if leads else f"no longer leads {squad}")
            self._was_leading[squad] = leads

    def _answer(self, data: bytes) -> bytes:
        """Answer a question; it is called in a thread of the network, and waits for the next tick."""
        try:
            question = msgspec.msgpack.decode(data, type=AgentQuestion)
        except UNREADABLE:
            return msgspec.msgpack.encode(
                AgentAnswer(problem="was asked something that it does not understand")
            )
        if question.do == "stop" and self.robot is not None:
            self.robot.emergency_stop(f"asked to by {question.by}")  # at once, from any thread
        if question.do == "ready":
            return msgspec.msgpack.encode(self._make_ready())
        if question.do in ("prepare", "forget"):  # which takes a while, in which decisions go on
            return msgspec.msgpack.encode(AgentAnswer(problem=self._prepare_library(question)))
        waiting, answered = Future[AgentAnswer](), Event()
        waiting.add_done_callback(lambda _: answered.set())
        self._asked.put((question, waiting))
        # What cannot be withdrawn any more is being carried out.
        if not self._clock.wait(answered, ANSWER_S) and waiting.cancel():
            answer = AgentAnswer(problem="did not answer in time")
        else:
            answer = waiting.result()
        return msgspec.msgpack.encode(answer)

    def _make_ready(self) -> AgentAnswer:
        """Prepare to arm the robot, and give a permit for it; it takes half a second, in which decisions go on."""
        if self.robot is None:
            return AgentAnswer(problem="has no robot")
        stop_count = self.robot.stop_count
        try:
            self.robot.prepare()
        except UnderstudyError as error:
            return AgentAnswer(problem=str(error))
        return AgentAnswer(permit=self._permits.give(stop_count))

    def _carry_out(self) -> None:
        while True:
            try:
                question, waiting = self._asked.get_nowait()
            except Empty:
                return
            if waiting.set_running_or_notify_cancel():
                waiting.set_result(self._carry_out_one(question))

    def _carry_out_one(self, question: AgentQuestion) -> AgentAnswer:
        if question.do == "status":
            return AgentAnswer(status=self.describe())
        if question.do == "logs":
            return AgentAnswer(log=list(self._log))
        if question.do == "stop":
            self.note(f"stopped by {question.by}")
            return AgentAnswer(status=self.describe())
        if question.do == "leave":
            self.note(f"told to leave by {question.by}")
            self.left = True
            return AgentAnswer()
        if question.do == "arm":
            return self._arm(question.by, question.permits.get(self.name, ""))
        if question.do in ("switch", "restart"):
            return AgentAnswer(problem=self._take_over(question))
        return AgentAnswer(problem=f"does not know {question.do!r:.40}")

    def _prepare_library(self, question: AgentQuestion) -> str:
        """Prepare or forget another library, in a thread of the network; return why that is impossible, or nothing."""
        if question.do == "forget":
            return self._library.forget()
        self._library.settle()  # an earlier push has ended, however it did
        return self._find_armed() or self._library.prepare(question.files)

    def _take_over(self, question: AgentQuestion) -> str:
        """Replace the library, or restart with the new one; return why that is impossible, or nothing."""
        if question.do == "restart":
            self._library.settle()  # all agents have it
        if problem := self._find_armed():
            return problem
        if question.do == "switch":
            return self._library.switch()
        self.note(f"took over the library of {question.by}")
        self.left = self.restarts = True
        return ""

    def _find_armed(self) -> str:
        """Return why the library cannot be replaced now: the robot is armed; empty if it is not."""
        return "is armed: stop it first" if self.robot is not None and self.robot.armed else ""

    def _arm(self, by: str, permit: str) -> AgentAnswer:
        if self.robot is None:
            return AgentAnswer(problem="has no robot")
        stop_count = self._permits.use(permit)
        if stop_count is None:
            return AgentAnswer(problem="was told to arm too late: arm it again")
        try:
            self.robot.arm(by, stop_count=stop_count)
        except UnderstudyError as error:
            return AgentAnswer(problem=str(error))
        self.note(f"armed by {by}")
        return AgentAnswer(status=self.describe())

    def describe(self) -> AgentStatus:
        """Describe what this agent does."""
        leading = [each for each in self.coordinators if each.leads]
        acting = self.agent or next((each.agent for each in leading), None)
        follower = None if acting is None else acting.follower
        refusals = {} if acting is None else acting.refusals
        missing = {
            member.name: problem
            for coordinator in self.coordinators
            if coordinator.leads
            or coordinator.spec.name == self.name  # which does not lead if it hears no other agent
            for members in coordinator.members
            for member in members.members
            if (problem := members.find_problem(member))
        }
        return AgentStatus(
            name=self.name,
            sort=self.team.plan.find_sort(self.name),
            path=[] if acting is None else list(acting.path),
            duty="" if acting is None else self._describe_duty(acting),
            order=None if follower is None else follower.order,
            order_age_s=(
                None
                if acting is None or follower is None or follower.order is None
                else round(acting.body.time_s - acting.begun_s, 3)
            ),
            leader=None if follower is None else follower.leader,
            term=0 if follower is None else follower.term,
            armed=None if self.robot is None else self.robot.armed,
            trainer=""
            if self.agent is None or not self.agent.is_driven
            else self.team.settings.trainer or "",
            unfit="" if self.agent is None else self.agent.unfitness,
            leads={each.spec.name: each.leadership.term for each in leading},
            decides={each.spec.name: list(each.agent.path) for each in leading},
            missing=missing,
            library=self.team.fingerprints[self.team.plan.find_sort(self.name)],
            refused={str(reason): count for reason, count in refusals.items()},
            ticks=self.ticks,
            late=self.late,
        )

    @staticmethod
    def _describe_duty(agent: Agent) -> str:
        follower = agent.follower
        if follower is None or follower.duty is None:
            return ""
        behavior, binding = follower.duty
        return str(Assignment(behavior, Binding(binding)))


def _stamp() -> str:
    """Return the time of day, to a millisecond."""
    now = time.time()
    return f"{time.strftime('%H:%M:%S', time.localtime(now))}.{int(now * 1000) % 1000:03d}"
