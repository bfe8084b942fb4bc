"""The agents of a body that are not trained, and the behaviors that they run during training."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple, TypeAlias

from understudy.errors import SessionError, UnderstudyError
from understudy.model.library import Library
from understudy.runtime.body import Body, Rewindable, is_rewindable
from understudy.runtime.interpreter import Interpreter, StackFrame
from understudy.runtime.link import IDLE_PROGRAM, Program, link
from understudy.runtime.run_loop import Run
from understudy.training.journal import OthersChanged
from understudy.training.trainee import FlagEntry, Mode

RunStates: TypeAlias = tuple[tuple[StackFrame, ...], ...]


NO_SIMULATION = "it is not simulated; drive the robot into position instead"


def require_rewindable(body: Body) -> Rewindable:
    """Return the body as one that can be rewound; SessionError if it cannot."""
    if not is_rewindable(body):
        raise SessionError(f"this body cannot be rewound: {NO_SIMULATION}")
    return body


class SessionSnapshot(NamedTuple):
    """A moment of a session's run: body, run states of all agents, mode, and where a flag was raised."""

    body: bytes
    run: tuple[StackFrame, ...]
    mode: Mode
    others: RunStates
    raised: FlagEntry | None = None


class OtherAgents:
    """All agents of a body; `run` puts the trained one among them."""

    def __init__(self, body: Body, library: Library, past: OthersChanged | None = None) -> None:
        self._body, self._library = body, library
        self.set_behavior(None)
        if past is not None:
            with suppress(UnderstudyError):  # the library has it no more: they idle
                self.set_behavior(past.behavior, past.targets)

    @property
    def programs(self) -> tuple[Program, ...]:
        """What each agent of the body runs while it is not trained."""
        return tuple(member.program for member in self._members)

    def run(self, agent: int, driver: Interpreter) -> Run:
        """Make the run in which `driver` drives one agent, and the others do what they are set to."""
        members = list(self._members)
        members[agent] = driver
        return Run(self._body, members)

    def set_behavior(
        self,
        behavior: str | None,
        binding: Mapping[str, str] | None = None,
        *,
        library: Library | None = None,
    ) -> None:
        """Let all other agents idle (None), or begin a behavior of the library, or of another one."""
        source = library or self._library
        program = IDLE_PROGRAM if behavior is None else link(source, behavior, binding or {})
        self.behavior_call = OthersChanged(behavior, dict(binding or {}))
        self._members = [Interpreter(program, now=self._body.time_s) for _ in range(self._body.agents)]

    def take_over(self, members: Sequence[Interpreter]) -> None:
        """Let each of the other agents run the program that its interpreter has, one interpreter per agent."""
        self.behavior_call = OthersChanged(None, {})
        self._members = list(members)

    def start(self) -> None:
        """Start their behaviors again."""
        for member in self._members:
            member.start(self._body.time_s)

    def snapshot(self) -> RunStates:
        """Return their run states, to be passed to `restore`."""
        return tuple(member.snapshot(self._body.time_s) for member in self._members)

    def restore(self, snapshot: Sequence[Sequence[StackFrame]]) -> None:
        """Go back to run states, for agents whose programs are still the same."""
        for member, levels in zip(self._members, snapshot, strict=True):
            member.restore(levels, now=self._body.time_s)
