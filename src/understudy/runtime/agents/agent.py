"""An agent that decides for itself: it senses, reports to its squad, and follows its order or runs its own program."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from secrets import randbits

import numpy as np

from understudy.errors import UnderstudyError
from understudy.model.binding import Binding
from understudy.model.features import Percept, ReadingKey
from understudy.runtime.agents.leadership import FROZEN_S
from understudy.runtime.agents.messages import (
    Duty,
    MemberReport,
    UnreadableMessage,
    compute_layout,
    decode_orders,
    pack_message,
)
from understudy.runtime.agents.network import Network
from understudy.runtime.agents.order_follower import OrderFollower, Refusal
from understudy.runtime.agents.training_link import (
    TrainerFollower,
    decode_trainer_command,
    trainer_command_key,
)
from understudy.runtime.body import SKILL, Body, Commands, SkillPerformer
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import IDLE_PROGRAM, Program
from understudy.runtime.run_loop import Run
from understudy.runtime.team.members import Finds


@dataclass(frozen=True, slots=True)
class SquadLink:
    """A member's place in its squad.

    Attributes
    ----------
    squad
        The name of the squad.
    candidates
        The agents that may lead it, the first choice first.
    keys
        The readings that the member reports.
    library
        The fingerprint that the coordinator's library must have; None: any.
    """

    squad: str
    candidates: Sequence[str]
    keys: Sequence[ReadingKey]
    library: str | None = None


@dataclass(frozen=True, slots=True)
class AgentSpec:
    """What an agent runs.

    Attributes
    ----------
    name
        The name of the agent.
    finds
        A function that makes a behavior that it can run, ready to run.
    programs
        All programs that it may be ordered to run.
    alone
        The program that it runs without an order.
    library
        The fingerprint of its library.
    link
        Its place in its squad; None if it is in none.
    trainer
        The agent from which a person may train it, and so drive it; None: none.
    """

    name: str
    finds: Finds
    programs: Sequence[Program]
    alone: Program = IDLE_PROGRAM
    library: str = ""
    link: SquadLink | None = None
    trainer: str | None = None

    def list_programs(self) -> list[Program]:
        """List all programs that it may run."""
        return [self.alone, IDLE_PROGRAM, *self.programs]


class Agent:
    """One robot, or one coordinator, that decides for itself.

    Parameters
    ----------
    spec
        What it runs.
    body
        Its body, with one agent.
    network
        Its access to the network.
    unfit
        A function that returns why it must not be counted as a member now; empty if it is fit.
    clock
        The clock of leases, s; None: the body's.
    shared
        What runs it together with other agents of its process, and its row there; None: a run of its own.
    """

    def __init__(
        self,
        spec: AgentSpec,
        body: Body,
        network: Network,
        *,
        unfit: Callable[[], str] = lambda: "",
        clock: Callable[[], float] | None = None,
        shared: tuple[Run, int] | None = None,
    ) -> None:
        self._read_clock = clock or (lambda: body.time_s)
        self.spec, self.body, self._network, self._unfit = spec, body, network, unfit
        programs = spec.list_programs()
        if shared is None:
            self.run, self._row = Run(body, [Interpreter(spec.alone, now=body.time_s)], programs), 0
        else:
            self.run, self._row = shared
            self.run.begin([self._row], spec.alone)
        self._runnable = {id(program) for program in programs}
        self._lacking = ""
        self.percept: Percept = {}
        self.refusals: dict[Refusal, int] = {}
        """The number of messages that were refused, by reason."""
        self.beginnings = 0
        """How often it began something since it was made."""
        self.begun_s = body.time_s
        """When it began its present program, s."""
        self._ran_s = self._now
        self.renew_start()
        self.follower: OrderFollower | None = None
        self.driver: TrainerFollower | None = None
        """The messages of its trainer; None if it has no trainer."""
        self._was_driven = False
        if spec.trainer is not None:
            self.driver = TrainerFollower(spec.trainer)
            self._drives = network.listen(trainer_command_key(spec.name))
        self.keys = () if shared else tuple(self.run.keys)
        """The readings that it reports and, with a run of its own, those that it decides on."""
        if spec.link is not None:
            link = spec.link
            self.follower = OrderFollower(spec.name, link.candidates, library=link.library)
            self._inbox = network.listen(order_key(link.squad))
            self.keys = tuple(dict.fromkeys((*self.keys, *link.keys)))
            self._layout = compute_layout(link.keys)

    @property
    def interpreter(self) -> Interpreter:
        """The interpreter of its present program."""
        return self.run.interpreters[self._row]

    @property
    def path(self) -> tuple[str, ...]:
        """The current state of every level, from the root down."""
        return self.run.path(self._row)

    def renew_start(self) -> None:
        """Count reports from 1 again, as those of another program."""
        self._start, self._sequence = randbits(53), 0

    def sense(self) -> None:
        """Take this tick's snapshot."""
        self.percept = self.body.sense(self.keys)

    def report(self) -> None:
        """Report to the squad: readings of this tick, and the flag raised before it."""
        link, follower = self.spec.link, self.follower
        if link is None or follower is None:
            return
        self._sequence += 1
        message = MemberReport(
            member=self.spec.name,
            start=self._start,
            sequence=self._sequence,
            sent_s=self._now,
            term=follower.term,
            heard=follower.heard,
            order=follower.order,
            library=self.spec.library,
            unfit=self.unfitness,
            flag=self.interpreter.root.flag,
            path=list(self.path),
            layout=self._layout,
            readings=[float(self.percept[key][0]) for key in link.keys],
            kept=follower.find_kept_message(self._now),
        )
        self._network.publish(report_key(link.squad), pack_message(message))

    @property
    def unfitness(self) -> str:
        """The reason why it must not be counted as a member now; empty if it is fit."""
        return self._unfit() or self._lacking or ("is being trained" if self.is_driven else "")

    @property
    def is_driven(self) -> bool:
        """Whether a trainer drives it now."""
        return self.driver is not None and self.driver.holds(self._now)

    def obey(self) -> None:
        """Hear the orders that have arrived, and begin what holds now if that is new."""
        follower = self.follower
        orders = [] if follower is None else self._inbox.take_all()
        drives = [] if self.driver is None else self._drives.take_all()
        now = self._now  # after they were taken: the program may have been frozen at any moment before
        slept, self._ran_s = now - self._ran_s > FROZEN_S, now
        if slept:  # those that came before it was frozen are too old
            orders, drives = [], []
        self._obey_trainer(drives, now)
        if follower is None:
            return
        renewed = False
        for data in orders:
            try:
                refused = follower.receive(decode_orders(data), now)
            except UnreadableMessage:
                continue
            renewed = renewed or refused is None
            if refused is not None:
                self.refusals[refused] = self.refusals.get(refused, 0) + 1
        # What is executed now lasts until the next tick, so the lease has to last as long.
        is_new = follower.update(now if renewed else now + self.body.tick_s)
        if is_new and not self.is_driven:
            self.begin()

    @property
    def _now(self) -> float:
        return self._read_clock()

    def _obey_trainer(self, arrived: Sequence[bytes], now: float) -> None:
        """Receive a trainer's messages; run no program while it drives the agent, and begin again afterwards."""
        if self.driver is None:
            return
        for data in arrived:
            with suppress(UnreadableMessage):
                self.driver.receive(decode_trainer_command(data), now)
        is_driven = self.is_driven
        if is_driven and not self._was_driven:
            self._begin_program(IDLE_PROGRAM)
        elif self._was_driven and not is_driven:
            self.begin()
        self._was_driven = is_driven

    def begin(self) -> None:
        """Begin the duty of the present order (nothing if it has none for this agent); without an order, `alone`."""
        follower = self.follower
        program: Program | None = self.spec.alone
        self._lacking = ""
        if follower is not None and follower.order is not None:
            duty = follower.duty
            program = IDLE_PROGRAM if duty is None else self._find_program(duty)
            if duty is not None and program is None:
                self._lacking = f"cannot run {duty[0]}, which it was ordered to"
        self._begin_program(IDLE_PROGRAM if program is None else program)

    def _begin_program(self, program: Program) -> None:
        self.beginnings, self.begun_s = self.beginnings + 1, self.body.time_s
        self.run.begin([self._row], program)

    def _find_program(self, duty: Duty) -> Program | None:
        """Find the program of a duty; None if this agent, by its library, may not be ordered to run it."""
        try:
            program = self.spec.finds(duty[0], Binding(duty[1]))
        except UnderstudyError:
            return None
        return program if id(program) in self._runnable else None

    def act(self) -> None:
        """Decide on this tick's snapshot, and act; while a trainer drives the agent, execute its commands."""
        driven = self.find_driven_commands()
        self.body.act(self.run.decide(self.percept) if driven is None else driven)

    def find_driven_commands(self) -> Commands | None:
        """Return a trainer's command, without channels that the body does not have; None if none drives the agent."""
        driver = self.driver
        if driver is None or not self.is_driven:
            return None
        channels = {channel.name for channel in self.body.channels}
        commands = {name: column for name, column in driver.commands.items() if name in channels}
        if driver.skill is not None and isinstance(self.body, SkillPerformer):
            name, binding = driver.skill
            with suppress(UnderstudyError):  # a skill that it does not have
                commands[SKILL] = np.array([float(self.body.index_skill(name, binding))])
        return commands


def report_key(squad: str) -> str:
    """Return the key of the reports to a squad's coordinator."""
    return f"report/{squad}"


def order_key(squad: str) -> str:
    """Return the key of the orders to a squad's members."""
    return f"order/{squad}"
