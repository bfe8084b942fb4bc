"""What the agents do that are not being taught."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple, TypeAlias

from understudy.errors import SessionError, UnderstudyError
from understudy.model.library import Library
from understudy.runtime.body import Body, Rewindable, is_rewindable
from understudy.runtime.interpreter import Interpreter, StackFrame
from understudy.runtime.program import IDLE_PROGRAM, link
from understudy.runtime.run_loop import Run
from understudy.training.journal import OthersChanged
from understudy.training.trainee import FlagEntry, Mode

RunStates: TypeAlias = tuple[tuple[StackFrame, ...], ...]


NO_SIMULATION = "it is not simulated; drive the robot into position instead"


def require_rewindable(body: Body) -> Rewindable:
    """The body as one that can go back; SessionError where it cannot."""
    if not is_rewindable(body):
        raise SessionError(f"this body cannot be rewound: {NO_SIMULATION}")
    return body


class SessionSnapshot(NamedTuple):
    """A moment of a session's run: the body, the run states of what is taught and of the others, the mode, and where
    what was learned raised the flag that is up, if it did.
    """

    body: bytes
    run: tuple[StackFrame, ...]
    mode: Mode
    others: RunStates
    raised: FlagEntry | None = None


class OtherAgents:
    """All agents of a body; the one being taught has a place among them, which `run` gives to whoever drives it."""

    def __init__(self, body: Body, library: Library, past: OthersChanged | None = None) -> None:
        self._body, self._library = body, library
        self.set_behavior(None)
        if past is not None:
            with suppress(UnderstudyError):  # the library has it no more: they idle
                self.set_behavior(past.behavior, past.targets)

    def run(self, agent: int, driver: Interpreter) -> Run:
        """The run in which one agent is driven by somebody, and the others do as they do."""
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
        """Let all idle (None), or run a behavior of the library, or of another, from its start."""
        known = library or self._library
        program = IDLE_PROGRAM if behavior is None else link(known, behavior, binding or {})
        self.behavior_call = OthersChanged(behavior, dict(binding or {}))
        self._members = [Interpreter(program, now=self._body.time_s) for _ in range(self._body.agents)]

    def start(self) -> None:
        """Start afresh what they run."""
        for member in self._members:
            member.start(self._body.time_s)

    def snapshot(self) -> RunStates:
        """Their run states, for `restore`."""
        return tuple(member.snapshot(self._body.time_s) for member in self._members)

    def restore(self, snapshot: Sequence[Sequence[StackFrame]]) -> None:
        """Go back to run states, as far as they still do the same."""
        for member, levels in zip(self._members, snapshot, strict=True):
            member.restore(levels, now=self._body.time_s)
