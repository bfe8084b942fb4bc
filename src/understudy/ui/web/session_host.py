"""Hold the state of the studio: one world, one library, and at most one open training session."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from msgspec import UNSET

from understudy.addons.robots.twin import DigitalTwin, Ground
from understudy.clock import REAL_TIME
from understudy.errors import SessionError, SettingError, UnderstudyError
from understudy.model.library import Kit
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.sim.body_world import BodyWorld
from understudy.sim.scenario.schema import Scenario
from understudy.sim.sensing.sensor_table import list_range_scans
from understudy.sim.world import World
from understudy.training.other_agents import SessionSnapshot
from understudy.training.trainee import Mode
from understudy.ui.controller import formatting, interrupted_sessions
from understudy.ui.controller.arming import RobotArming
from understudy.ui.controller.beside import Beside, make_threads
from understudy.ui.controller.clock import IdleWorld, check_speed
from understudy.ui.controller.failing_worlds import LibrarySource
from understudy.ui.controller.open_session import OpenSession
from understudy.ui.controller.status import StatusMessage, describe_error, keep_status
from understudy.ui.controller.trainer import Trainer
from understudy.ui.web import frames
from understudy.ui.web.failure_results import FailingWorldList
from understudy.ui.web.places import Places
from understudy.ui.web.property_list import LibraryPropertyList
from understudy.ui.web.rewind import RewindBuffer, RewindPoint, RunData, UncertainMoments
from understudy.ui.web.unseen_worlds import UnseenWorldsEvaluation
from understudy.ui.web.views.library import InterruptedSessionData, LibraryData
from understudy.ui.web.views.scene import SceneData, describe_scene
from understudy.ui.web.views.session import (
    BehaviorCallData,
    SessionData,
    SessionViewBuilder,
)
from understudy.ui.web.views.team import ActivityNames, TrainableGroups

NOTHING = "No automaton is open: teach something new, or open one from the library"
CARRY = "drive the robot there, or carry it"
_ROBOT = re.compile(r"\brobot (\d+)")
_LONG = re.compile(r"-?\d+\.\d{3,}")


def _as_on_the_page(text: str) -> str:
    """Return a world's message with robots counted from 1 and long numbers rounded to two decimals."""
    text = _ROBOT.sub(lambda match: f"robot {int(match[1]) + 1}", text)
    return _LONG.sub(lambda match: f"{float(match[0]):.2f}", text)


class SessionHost:
    """The world, the library and the trainer of one studio; without a `ground`, the world is that of the scenario.

    `beside` does the work beside the world; None: threads do.
    `frame_version` grows whenever the frame changes, `scene_version` whenever the scene or the library changes.
    """

    def __init__(
        self,
        scenario: Scenario,
        folder: Path,
        kit: Kit,
        *,
        seed: int = 0,
        wall: Callable[[], float] = REAL_TIME,
        ground: Ground | None = None,
        failures: Path | None = None,
        beside: Beside | None = None,
    ) -> None:
        self.beside = make_threads() if beside is None else beside
        self.wall, self._speed = wall, 1.0
        self.open_session: OpenSession | None = None
        self.frame_version = self.scene_version = 0
        self.places = Places(scenario, kit, folder)
        self.properties = LibraryPropertyList(self.beside)
        self._place(ground or World(scenario, [seed]), folder, kit)
        self._status = StatusMessage(NOTHING)
        self._picture: SessionViewBuilder | None = None
        self.rewind_buffer, self.unsure = RewindBuffer(), UncertainMoments()
        self.evaluation: UnseenWorldsEvaluation | None = None
        self.failures = FailingWorldList(
            failures if isinstance(self.world, World) else None, wall, self.beside
        )
        self.run = RunData(number=0, from_s=0.0)
        self.refresh_interrupted()
        if self.cut_off:
            self._status = StatusMessage(
                f"Interrupted before it was saved: {', '.join(self.cut_off)}. Open it to resume"
            )

    def _place(self, world: Ground, folder: Path, kit: Kit) -> None:
        """Set the world, the library's folder and the kit that both are read with."""
        self.world, self.folder, self.first_kit = world, folder, kit
        self.robots = RobotArming(world, self.wall, place="the studio")
        self.groups = TrainableGroups(world.scenario, folder, kit)
        self.properties.use_folder(folder)
        self.sort: str | None = None  # the sort of squads that is trained; None: the robots
        self.library_view = self.groups.read_library(None)
        self.kit = self.library_view.library.kit
        self.doing = ActivityNames()
        self.agent, self.began_with = 0, 0  # the robot that is trained, and with how many examples
        self._idling = IdleWorld(world, self.wall)
        self.seen_seeds = set[int]()  # that of the trainer, too: see there
        self.discarded: dict[str, Path] = {}  # journals of lessons that were cut off and thrown away

    # What there is to see

    @property
    def scenario(self) -> Scenario:
        """The scenario of the world."""
        return self.world.scenario

    @property
    def trainer(self) -> Trainer | None:
        """The trainer of the open session; None if no session is open."""
        return None if self.open_session is None else self.open_session.trainer

    @property
    def active_trainer(self) -> Trainer:
        """The trainer of the open session; raises SessionError if no session is open."""
        if self.open_session is None:
            raise SessionError(NOTHING[0].lower() + NOTHING[1:])
        return self.open_session.trainer

    @property
    def status(self) -> StatusMessage:
        """The last status message."""
        return self._status if self.trainer is None else self.trainer.status

    @status.setter
    def status(self, message: StatusMessage) -> None:
        if self.trainer is None:
            self._status = message
        else:
            self.trainer.status = message

    @property
    def other_behavior(self) -> BehaviorCallData | None:
        """The behavior that the robots not in training run; None if they idle."""
        doing = None if self.trainer is None else self.trainer.session.other_agents.behavior_call
        if doing is None or doing.behavior is None:
            return None
        return BehaviorCallData.of(doing)

    @property
    def paused(self) -> bool:
        """Whether the world is paused."""
        return self._idling.paused if self.trainer is None else self.trainer.paused

    @property
    def speed(self) -> float:
        """The simulation speed as a multiple of real time."""
        return self._speed

    @property
    def library_source(self) -> LibrarySource:
        """The library's folder, as it is read in any scenario."""
        return LibrarySource(self.folder, self.places.find_kit)

    @property
    def seed(self) -> int:
        """The seed of the present world."""
        return self.world.seeds[0]

    def scene(self) -> SceneData:
        """Return the data of world and kit that do not change from tick to tick."""
        return describe_scene(self.world, self.kit, self.groups.data())

    def library(self) -> LibraryData:
        """Return the library folder as it was last read, with the interrupted sessions."""
        left = [
            InterruptedSessionData.of(each, name=name, began=each.began.isoformat())
            for name, each in self.cut_off.items()
        ]
        return self.library_view.data(left)

    def session_data(self) -> SessionData | None:
        """Return the open session as the page shows it; None if no session is open."""
        if self._picture is None:
            return None
        asking = self.unsure.data(self.active_trainer.coach)
        evaluation = UNSET if self.evaluation is None else self.evaluation.data
        return self._picture.build(
            others=self.other_behavior, doing=list(self.doing.names), asking=asking, evaluation=evaluation
        )

    def frame(self) -> bytes:
        """Encode the present state of the world as a binary frame."""
        trainer = self.trainer
        tick = int(self.world.state.tick[0])
        bits = frames.PAUSED * self.paused
        if trainer is None:
            return frames.encode_frame(
                self.world.view(), tick=tick, agent=self.agent, bits=bits, sonar=self._sonar()
            )
        view = trainer.session_view
        bits |= frames.OPEN | frames.TESTING * (view.mode is Mode.TESTING)
        return frames.encode_frame(
            self.world.view(),
            tick=tick,
            agent=frames.NONE if self.sort else trainer.robot,
            bits=bits,
            state=view.states.index(view.state),
            doing=self._doing(trainer),
            features=tuple(view.features.values()),
            sonar=self._sonar(),
        )

    def _doing(self, trainer: Trainer) -> list[int]:
        """Return for each robot the number of its activity; empty unless a coordinator is in training."""
        body = trainer.session.body
        return self.doing.numbers(body.team.paths) if isinstance(body, CoordinatorBody) else []

    def _sonar(self) -> tuple[float, ...]:
        if self.sort is not None:
            return ()
        kind = self.world.names.types[int(self.world.state.robots["type"][self.agent])]
        scans = list_range_scans(self.world.scenario.types[kind])
        keys = [(arc.reading, None) for scan in scans for arc in scan.arcs]
        if not keys:
            return ()
        percept = self.world.sense(keys) if self.trainer is None else self.trainer.session.percept
        return tuple(float(percept[key][self.agent]) for key in keys)

    def picture(self) -> bytes | None:
        """Encode the picture of a body that draws itself; None for any other world."""
        if not (isinstance(self.world, BodyWorld) and self.world.has_picture):
            return None
        picture = self.world.render()
        return None if picture is None else frames.encode_picture(picture)

    # Time

    def run_due_ticks(self) -> None:
        """Run the ticks that are due; on an error, pause and show its message."""
        trainer = self.trainer
        try:
            for _ in self._idling.ticks() if trainer is None else trainer.ticks():
                self.frame_version += 1
                self.note_tick()
            if self.evaluation is not None and (result := self.evaluation.take_status()) is not None:
                self.status = result
            self._advance_tests()
            if self.robots.idle():
                self.frame_version += 1
                if trainer is not None:
                    trainer.session.refresh_percept()
        except Exception as error:
            self.halt(describe_error(error))

    def _advance_tests(self) -> None:
        """Take over the results of failing worlds and properties that were run beside the world."""
        before = self.failures.result
        if (change := self.failures.advance(self.library_source, self.trainer)) is not None:
            self.status = change
        result = self.failures.result
        if result is not None and result is not before:
            stale = self.failures.is_stale(self.trainer)
            self.properties.take_rerun(result.properties, self.trainer, stale=stale)
        self.properties.advance()

    def step(self) -> None:
        """Run one tick, then pause."""
        self.frame_version += 1
        if self.trainer is None:
            self._idling.step()
            self._status = StatusMessage("Paused")
        else:
            self.trainer.step()
            self.note_tick()

    def note_tick(self) -> None:
        """Record the tick that just ran for rewinding and for the uncertain moments."""
        if self.trainer is not None:
            self._keep_moment()
            self.unsure.update(self.trainer.coach.asking.marked, self.run.number, self.world.time_s)

    @keep_status
    def halt(self, problem: str) -> StatusMessage:
        """Disarm real robots, pause, and return the problem as an error message."""
        self.robots.disarm(problem)
        self.pause(True)
        return StatusMessage(problem, "error")

    def pause(self, paused: bool, why: str | None = None) -> None:
        """Pause or resume."""
        self.frame_version += 1
        if self.paused != paused:
            if self.trainer is None:
                self._idling.pause(paused)
            else:
                self.trainer.pause()
            self.status = StatusMessage(why or ("Paused" if paused else "Resumed"))

    def set_speed(self, speed: float) -> None:
        """Set the simulation speed as a multiple of real time."""
        self._speed = self._idling.pace.speed = check_speed(speed, "the studio", live=self._idling.pace.live)
        if self.trainer is not None:
            self.trainer.set_speed(speed)

    @keep_status
    def reset(self, seed: int | None) -> StatusMessage:
        """Reset the world to a seed, or to its present seed if None."""
        seed = self.seed if seed is None else seed
        if self.trainer is None:
            if isinstance(self.world, DigitalTwin):
                raise SessionError(f"a world of real robots cannot be reset: {CARRY}")
            self.world.reset([seed])
            status = StatusMessage(f"World {seed}, from the start")
        else:
            status = self.trainer.load_world(seed)
        self.clear_rewind()
        return status

    def _begin_rewind(self) -> None:
        self.rewind_buffer.clear(() if self.trainer is None else self.trainer.session.examples)
        self.run = RunData(number=self.run.number + 1, from_s=self.world.time_s)
        self.seen_seeds.add(self.seed)
        self._keep_moment()

    def _keep_moment(self) -> None:
        if self.trainer is not None and isinstance(self.world, World):  # others cannot be gone back to
            self.rewind_buffer.append(self.trainer.session)

    def rewind(self, frame: RewindPoint) -> None:
        """Go back to a moment of the present run and pause there; the lesson is kept."""
        switches = self.active_trainer.explainer.list_switches_before(frame.time_s)
        self._back(frame.instant)
        self.active_trainer.explainer.restore_switches(switches)

    def go_back(self, instant: SessionSnapshot) -> None:
        """Restore a moment of this session, possibly of an earlier run, and begin a new run there."""
        self._back(instant)
        self._begin_rewind()

    def clear_rewind(self) -> None:
        """Begin a new run at the present moment, so that nothing before it can be rewound to."""
        self._begin_rewind()
        self.note_world_change()

    @keep_status
    def _back(self, instant: SessionSnapshot) -> StatusMessage:
        trainer = self.active_trainer
        self.pause(True)
        trainer.session.rewind(instant)
        trainer.note_moved("back")
        self.note_world_change()
        now = formatting.format_minutes(self.world.time_s)
        return StatusMessage(f"Back at {now}; the lesson is unchanged, and the run continues from here")

    def note_world_change(self) -> None:
        """Mark frame and scene as changed, after a change of the world that was not a tick."""
        self.frame_version += 1
        self.scene_version += 1

    @keep_status
    def edit_world(self, change: Callable[[World], object], what: str) -> StatusMessage:
        """Change the simulated world by hand and return `what` as the message; SessionError for any other."""
        if isinstance(self.world, DigitalTwin):
            raise SessionError(f"real robots and objects cannot be moved here: {CARRY}")
        if isinstance(self.world, BodyWorld):
            raise SessionError(f"{self.world.name} cannot be changed by hand: only its own code knows how")
        try:
            change(self.world)
        except SettingError as error:
            raise SessionError(_as_on_the_page(str(error))) from error
        self.frame_version += 1
        return StatusMessage(what) if self.trainer is None else self.trainer.note_moved(what)

    # Opening and closing

    def replace_session(self, opened: OpenSession, sentence: str) -> None:
        """Open a session in place of the present one, whose journal is finished."""
        policy = None if self.trainer is None else self.trainer.coach.chosen_policy
        self._leave()
        self._idling.pause(True)
        self.open_session, trainer = opened, opened.trainer
        self._picture, self.agent = SessionViewBuilder(trainer), trainer.robot
        self.unsure = UncertainMoments()
        if policy is not None:
            trainer.coach.choose_query_policy(policy)
        self.began_with = len(trainer.session.examples)
        self.seen_seeds |= trainer.seen_seeds
        trainer.seen_seeds = self.seen_seeds
        trainer.set_speed(self._speed)
        trainer.score.run_beside(self.beside)
        trainer.suspend(False)
        trainer.status = StatusMessage(sentence)
        self._begin_rewind()
        self.refresh_interrupted()
        self.note_world_change()

    def enter(self, world: World, folder: Path, kit: Kit) -> None:
        """Close the present session, and go to another world and to the library in a folder."""
        self._leave()
        self._place(world, folder, kit)
        self.unsure = UncertainMoments()
        self.set_speed(self._speed)
        self.refresh_interrupted()
        self.clear_rewind()

    def select_agents(self, sort: str | None, agent: int) -> None:
        """Close the present session and select robots (None) or a sort of squads for training."""
        self._leave()
        self.sort, self.agent = sort, agent
        self.doing = ActivityNames()
        self.refresh_library()
        self.refresh_interrupted()
        self.note_world_change()

    @property
    def body(self) -> Ground | CoordinatorBody:
        """The body in training: the world's robots, or the coordinators of the selected sort of squads."""
        return self.groups.body(self.world, self.sort)

    def end_evaluation(self) -> None:
        """Cancel a running evaluation in unseen worlds and drop its result."""
        if self.evaluation is not None:
            self.evaluation.cancel()
            self.evaluation = None

    def _leave(self) -> None:
        self.end_evaluation()
        if self.open_session is not None:
            left, self.open_session, self._picture = self.open_session, None, None
            left.close()
            interrupted_sessions.finish_journal(left.journal, self.library_view.folder, left.trainer.name)

    def close(self) -> None:
        """Close the session; one with unsaved changes is offered for resuming at the next start."""
        self.beside.close()
        self.end_evaluation()
        self.failures.cancel()
        self.properties.cancel()
        if self.open_session is None:
            return
        if self.open_session.trainer.has_unsaved_changes:
            self.open_session.close()
            self.open_session, self._picture = None, None
        else:
            self._leave()

    def refresh_library(self) -> None:
        """Read the library folder again and make new automata available to the open session."""
        self.library_view = self.groups.read_library(self.sort, self.agent)
        self.kit = self.library_view.library.kit
        if not self.failures.is_running:
            self.failures.read()
        self.properties.read()
        if self.trainer is not None:
            session = self.trainer.session
            for name, taught in self.library_view.library.taught.items():
                if name not in session.library.taught and name != self.trainer.name:
                    with suppress(UnderstudyError):  # it would contain itself, by what is older in the lesson
                        session.library = session.library.with_automaton(taught)
        self.scene_version += 1

    def refresh_interrupted(self) -> None:
        """Read the journals of interrupted sessions again, which may take a moment."""
        world = self.world.scenario.name
        sessions = interrupted_sessions.list_interrupted_sessions(
            self.library_view.folder, world, self.library_view.library
        )
        here = (
            None if self.open_session is None else self.open_session.journal
        )  # where journals cannot be locked
        self.cut_off = {name: each for name, each in sessions.items() if each.path != here}
        self.scene_version += 1
