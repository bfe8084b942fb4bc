"""An agent that decides for itself: it senses, reports to its squad, and does what holds for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
from understudy.runtime.body import Body
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.program import IDLE_PROGRAM, Program
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
    """

    name: str
    finds: Finds
    programs: Sequence[Program]
    alone: Program = IDLE_PROGRAM
    library: str = ""
    link: SquadLink | None = None


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
    """

    def __init__(
        self, spec: AgentSpec, body: Body, network: Network, *, unfit: Callable[[], str] = lambda: ""
    ) -> None:
        self.spec, self.body, self._network, self._unfit = spec, body, network, unfit
        first = Interpreter(spec.alone, now=body.time_s)
        programs = [spec.alone, IDLE_PROGRAM, *spec.programs]
        self.run = Run(body, [first], programs)
        self._runnable = {id(program) for program in programs}
        self._lacking = ""
        self.percept: Percept = {}
        self.refusals: dict[Refusal, int] = {}
        """The number of messages that were refused, by reason."""
        self._ran_s = body.time_s
        self.renew_start()
        self.follower: OrderFollower | None = None
        self._keys = tuple(self.run.keys)
        if spec.link is not None:
            link = spec.link
            self.follower = OrderFollower(spec.name, link.candidates, library=link.library)
            self._inbox = network.listen(order_key(link.squad))
            self._keys = tuple(dict.fromkeys((*self._keys, *link.keys)))
            self._layout = compute_layout(link.keys)

    def renew_start(self) -> None:
        """Count reports from 1 again, as those of another program."""
        self._start, self._sequence = randbits(53), 0

    def sense(self) -> None:
        """Take this tick's snapshot."""
        self.percept = self.body.sense(self._keys)

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
            sent_s=self.body.time_s,
            term=follower.term,
            heard=follower.heard,
            order=follower.order,
            library=self.spec.library,
            unfit=self._unfit() or self._lacking,
            flag=self.run.interpreters[0].root.flag,
            path=list(self.run.path(0)),
            layout=self._layout,
            readings=[float(self.percept[key][0]) for key in link.keys],
        )
        self._network.publish(report_key(link.squad), pack_message(message))

    def obey(self) -> None:
        """Hear the orders that have arrived, and begin what holds now if that is new."""
        follower = self.follower
        if follower is None:
            return
        now = self.body.time_s
        slept, self._ran_s = now - self._ran_s > FROZEN_S, now
        arrived, renewed = self._inbox.take_all(), False
        for data in [] if slept else arrived:  # those that came before this program was frozen are too old
            try:
                refused = follower.receive(decode_orders(data), now)
            except UnreadableMessage:
                continue
            renewed = renewed or refused is None
            if refused is not None:
                self.refusals[refused] = self.refusals.get(refused, 0) + 1
        # What is executed now lasts until the next tick, so the lease has to last as long.
        if follower.update(now if renewed else now + self.body.tick_s):
            self.begin()

    def begin(self) -> None:
        """Begin what holds now: the duty of its order, nothing if the order has none for it, or what it does alone."""
        follower = self.follower
        program: Program | None = self.spec.alone
        self._lacking = ""
        if follower is not None and follower.order is not None:
            duty = follower.duty
            program = IDLE_PROGRAM if duty is None else self._find_program(duty)
            if duty is not None and program is None:
                self._lacking = f"cannot run {duty[0]}, which it was ordered to"
        self.run.begin(np.array([0]), IDLE_PROGRAM if program is None else program)

    def _find_program(self, duty: Duty) -> Program | None:
        """Find what a duty tells to run; None if it is nothing that this agent, by its library, may be ordered."""
        try:
            program = self.spec.finds(duty[0], Binding(duty[1]))
        except UnderstudyError:
            return None
        return program if id(program) in self._runnable else None

    def act(self) -> None:
        """Decide on this tick's snapshot, and act."""
        self.body.act(self.run.decide(self.percept))


def report_key(squad: str) -> str:
    """Return the key of the reports to a squad's coordinator."""
    return f"report/{squad}"


def order_key(squad: str) -> str:
    """Return the key of the orders to a squad's members."""
    return f"order/{squad}"
