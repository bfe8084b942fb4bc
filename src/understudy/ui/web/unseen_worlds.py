"""An evaluation of what is in training in unseen worlds, beside the world on the page."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError
from threading import Thread
from time import sleep

from msgspec import structs

from understudy.analysis.evaluation import Evaluation
from understudy.analysis.rollout import Progress
from understudy.ui.controller.status import StatusMessage, describe_error
from understudy.ui.web.views.session import EvaluationData, describe_evaluation

YIELD_S = 0.0002
"""The pause of an evaluation after each progress report, s.

Without it, the thread that advances the world on the page would wait 5 ms for the interpreter each time.
"""


class UnseenWorldsEvaluation:
    """An evaluation of the automaton in training in unseen worlds, run in a thread of its own."""

    def __init__(
        self, called: str, edition: int, *, worlds: int, evaluate: Callable[[Progress], Evaluation]
    ) -> None:
        self.data = EvaluationData(
            called=called, edition=edition, worlds=worlds, through=0, result=None, problem=""
        )
        self._cancelled, self._untold = False, True
        Thread(target=self._run, args=(evaluate,), daemon=True).start()

    @property
    def is_running(self) -> bool:
        """True as long as the evaluation has neither a result nor an error, also after `cancel`."""
        return self.data.result is None and not self.data.problem

    def cancel(self) -> None:
        """Cancel the evaluation at its next progress report; it gets no result."""
        self._cancelled = True

    def take_status(self) -> StatusMessage | None:
        """Return the message about the finished evaluation on the first call after its end, else None."""
        data = self.data
        if self.is_running or not self._untold:
            return None
        self._untold = False
        if data.result is None:
            return StatusMessage(data.problem, "error")
        worlds = f"{data.worlds} world{'s' * (data.worlds != 1)}"
        raised = f" ({data.result.raised})" if data.result.raised else ""
        return StatusMessage(
            f"{data.called} succeeded in {data.result.succeeded} of {worlds}{raised}",
            "error" if data.result.leaves_shown else "",
        )

    def _run(self, evaluate: Callable[[Progress], Evaluation]) -> None:
        try:
            self.data = structs.replace(self.data, result=describe_evaluation(evaluate(self._report)))
        except CancelledError:
            pass
        except Exception as error:
            self.data = structs.replace(self.data, problem=describe_error(error))

    def _report(self, through: int, _: int) -> None:
        if self._cancelled:
            raise CancelledError
        if through != self.data.through:
            self.data = structs.replace(self.data, through=through)
        sleep(YIELD_S)
