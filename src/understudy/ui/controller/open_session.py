"""Opening a session for the trainer: a new one or an interrupted one, each with its journal."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from understudy.addons.robots.twin import DigitalTwin, Ground
from understudy.errors import SessionError
from understudy.model.lesson import Lesson
from understudy.records.header import RunInfo
from understudy.runtime.body import Body
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.sim.body_world import BodyWorld
from understudy.sim.world import World
from understudy.training.session import Session
from understudy.ui.controller.clock import RealTimeClock, choose_clock
from understudy.ui.controller.interrupted_sessions import make_journal_path
from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.trainer import Trainer
from understudy.ui.controller.training_plan import SessionStart, TrainingPlan


class OpenSession:
    """A trainer with its journal, which no other session can write until this one is closed."""

    def __init__(self, trainer: Trainer, journal: Path) -> None:
        self.trainer, self.journal = trainer, journal
        self._closed = False

    def close(self) -> None:
        """Write everything to disk and release the journal; later calls do nothing."""
        if not self._closed:
            self._closed = True
            self.trainer.session.close()


def begin_session(
    plan: TrainingPlan,
    start: SessionStart,
    wall: Callable[[], float],
    *,
    body: Ground | CoordinatorBody | None = None,
    agent: int = 0,
    carried_to: str = "",
    now: datetime | None = None,
) -> OpenSession:
    """Begin a session with a new journal, in a world of its own or in an existing one as it is.

    A body of the user's own begins paused, since its episode may be over within a moment. `carried_to` names the world
    to which a lesson with unsaved examples goes on from another session; so it is offered again if this one is cut off.
    """
    body = World(plan.world, [plan.seed]) if body is None else body
    ground = find_ground(body)
    pace = RealTimeClock(choose_clock(ground, wall), tick_s=body.tick_s, live=isinstance(ground, DigitalTwin))
    journal = make_journal_path(plan.folder, plan.name, now=now or datetime.now())
    session = Session(
        body,
        plan.library,
        start.lesson,
        targets=start.targets,
        agent=agent,
        clock=lambda: pace.time_s,
        journal=journal,
        about={"world": plan.world.name, "seed": plan.seed, "carried_to": carried_to},
    )
    trainer = Trainer(session, ground, pace, folder=plan.folder, seed=plan.seed, saved=_saved(plan))
    if isinstance(ground, BodyWorld):
        trainer.pause()
    trainer.status = StatusMessage(_welcome(trainer))
    _follow(session, ground)
    return OpenSession(trainer, journal)


def resume_session(
    plan: TrainingPlan,
    journal: Path,
    wall: Callable[[], float],
    *,
    body: Ground | CoordinatorBody | None = None,
) -> OpenSession:
    """Resume an interrupted session, paused; an existing world becomes as it was then."""
    body = World(plan.world, [plan.seed]) if body is None else body
    ground = find_ground(body)
    pace = RealTimeClock(choose_clock(ground, wall), tick_s=body.tick_s, live=isinstance(ground, DigitalTwin))
    session = Session.resume(journal, body, plan.library, clock=lambda: pace.time_s)
    trainer = Trainer(session, ground, pace, folder=plan.folder, seed=None, saved=_saved(plan))
    _follow(session, ground)
    trainer.pause()
    trainer.status = StatusMessage("The lesson is restored. Space resumes, n begins in a new world")
    return OpenSession(trainer, journal)


def find_ground(body: Body) -> Ground:
    """Return the body to display: for squads, that of their robots. SessionError if there is no picture of it."""
    ground = body.ground if isinstance(body, CoordinatorBody) else body
    if not isinstance(ground, World | DigitalTwin | BodyWorld):
        raise SessionError(
            f"there is no picture of a {type(ground).__name__}: give the session a body that is a World, or robots "
            "of one"
        )
    return ground


def _follow(session: Session, ground: Ground) -> None:
    """Let real robots publish and record the decisions."""
    if not isinstance(ground, DigitalTwin):
        return
    body, ran = session.body, RunInfo(library="", binding=dict(session.view().targets))

    def paths() -> list[tuple[str, ...]]:
        if isinstance(body, CoordinatorBody):
            return body.team.paths
        return [session.trainee.path if each == session.agent else () for each in range(body.agents)]

    ground.follow(paths)
    ground.record(ran)


def _saved(plan: TrainingPlan) -> Lesson | None:
    taught = plan.library.taught.get(plan.name)
    return None if taught is None else taught.lesson


def _welcome(trainer: Trainer) -> str:
    if trainer.session.examples:
        return f"Opened {trainer.name}: t tests it, the keys of the states direct it, h shows help"
    return f"Direct the robot with the keys of the states: each press teaches {trainer.name}. h shows help"
