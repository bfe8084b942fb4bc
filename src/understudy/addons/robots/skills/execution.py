"""One execution of a skill, from its start to its outcome; events may arrive in any order and in any thread."""

from __future__ import annotations

from collections.abc import Mapping
from threading import Lock
from typing import Any

CANCELLED = "cancelled"
"""The outcome of an execution that this program ended; no reading has it."""


class Execution:
    """An execution of a skill since `began_s` (s).

    The first outcome counts: later answers of the robot change nothing.
    """

    def __init__(self, began_s: float) -> None:
        self.began_s = began_s
        self.outcome, self.problem = "", ""
        self.feedback: Mapping[str, float] = {}
        self.goal: Any = None
        """The message that was sent; None before that."""
        self.result: Any = None
        """The robot's answer at the end, if there was one."""
        self._lock = Lock()

    @property
    def runs(self) -> bool:
        """True until it has an outcome."""
        return not self.outcome

    def end(self, outcome: str, problem: str = "") -> bool:
        """Give it an outcome, and a problem in words; return whether it had none yet."""
        with self._lock:
            if self.outcome:
                return False
            self.outcome, self.problem = outcome, problem
            return True
