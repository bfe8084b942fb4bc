"""The trainer: a session with all actions and displays of a user interface, independent of any screen.

Every action returns its result in one sentence (`status`), or raises an UnderstudyError if it is not possible.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Unpack

from understudy.addons.robots.twin import DigitalTwin, Ground, find_drawn_world, skip_note
from understudy.errors import SessionError
from understudy.judging.properties.lesson_tests import find_regressions_since_saved
from understudy.model.change_summary import ChangeSummary
from understudy.model.features import BoundFeature
from understudy.model.lesson import Lesson
from understudy.model.library import TrainedAutomaton
from understudy.sim.body_world import BodyWorld
from understudy.sim.target_lookup import find_target_place
from understudy.sim.view import WorldView
from understudy.training.edits import ExampleChange
from understudy.training.session import Session
from understudy.training.trainee import Mode
from understudy.ui.controller import formatting
from understudy.ui.controller.clock import RealTimeClock, check_speed
from understudy.ui.controller.coach import CoachController, pause_for_question
from understudy.ui.controller.explainer import DecisionExplainer
from understudy.ui.controller.keep_going import LessonContinuation
from understudy.ui.controller.key_bindings import KeyBindings, bind_drive_keys, bind_state_keys
from understudy.ui.controller.recent_history import RecentHistory
from understudy.ui.controller.saved_lesson import SavedLesson
from understudy.ui.controller.score_keeper import LessonScoreKeeper
from understudy.ui.controller.status import StatusMessage, Tone, keep_status
from understudy.ui.controller.training_plan import LessonChoices, check_new_name
from understudy.ui.controller.world_grid import WorldGrid


class Trainer:
    """A session in a world, in real time. `saved` is the lesson as the library has it.

    `seen_seeds` are those of the worlds that were on the screen, or among which a situation was chosen: a robot that
    works there proves nothing.
    """

    def __init__(
        self,
        session: Session,
        body: Ground,
        pace: RealTimeClock,
        *,
        folder: Path,
        seed: int | None,
        saved: Lesson | None,
    ) -> None:
        self.session, self.body, self.pace = session, body, pace
        self.note = body.record_action if isinstance(body, DigitalTwin) else skip_note
        self.seen_seeds = set[int]()
        self.folder, self.seed = folder, seed
        self.memory, self.explainer = RecentHistory(), DecisionExplainer(session)
        self.score, self.continuation = LessonScoreKeeper(session), LessonContinuation(self)
        self.world_grid = WorldGrid(self)
        self.coach = CoachController(session, self.explainer, self.score)
        self.status = StatusMessage("")
        self.corrected = False
        self.driving = False
        self.steering: str | None = None
        self.suspended = False
        self._noted_live = False
        self.drivers = [each for each in session.library.kit.behaviors.values() if not each.parameters]
        self.drive_keys = bind_drive_keys(self.drivers)
        self._saved = SavedLesson(folder, saved)
        self.session_view = session.view()
        self._options = session.lesson.options
        self._redraw_keys()

    def _redraw_keys(self) -> None:
        self.keys: KeyBindings = bind_state_keys(self.session.library, self.session.automaton.states)

    # What there is to see

    @property
    def name(self) -> str:
        """The name of the automaton in training."""
        return self.session.automaton.name

    @property
    def seed(self) -> int | None:
        """The seed of the world; None if it is not known."""
        return self._seed

    @seed.setter
    def seed(self, seed: int | None) -> None:
        self._seed = seed
        if seed is not None:
            self.seen_seeds.add(seed)

    @property
    def features(self) -> Sequence[BoundFeature]:
        """The features of the lesson."""
        return self.session.automaton.features

    @property
    def paused(self) -> bool:
        """Whether the person paused the run."""
        return self.session.paused

    @property
    def view(self) -> WorldView:
        """Return the world, for drawing."""
        return self.body.view(self.session.agent // self.body.robots)

    @property
    def robot(self) -> int:
        """The index of the robot that is trained, in its world."""
        return self.session.agent % self.body.robots

    def list_target_places(self) -> list[tuple[float, float]]:
        """List the places (m) of the targets of the parameters; none for a squad or a body of the user's own."""
        session, body = self.session, self.body
        if session.body is not body or isinstance(body, BodyWorld):
            return []
        places = (
            find_target_place(find_drawn_world(body), target, session.agent)
            for target in self.session_view.targets.values()
        )
        return [place for place in places if place is not None]

    @property
    def has_unsaved_changes(self) -> bool:
        """Whether the lesson differs from the one in the library."""
        return self._saved.differs_from(self.session)

    @property
    def change_to_save(self) -> ChangeSummary | None:
        """What the automaton decides otherwise than in the library, apart from what presses since then say."""
        return self._saved.summarize_change(*self.explainer.learn_lesson())

    @property
    def can_watch(self) -> bool:
        """Whether the lesson learns from silence."""
        return self._options.watched

    # Time

    def run_due_ticks(self) -> bool:
        """Take the ticks that are due, and return whether there were any."""
        return sum(1 for _ in self.ticks()) > 0

    def ticks(self) -> Iterator[None]:
        """Take the ticks that are due, one after the other."""
        if (change := self.score.take_change()) is not None and change.has_fallen:
            self.status = StatusMessage(change.describe(), "error")
        for _ in self.pace.ticks():
            self.tick()
            yield
            if self.paused:  # it asks
                return

    def tick(self) -> None:
        """Take one tick, and set the status to its result."""
        marks = self.coach.asking.marked[-1:]
        if (question := self.coach.asking.find_question()) is not None:
            pause_for_question(self, question)
            return
        before, session = self.session_view, self.session
        count_before = len(session.examples)
        self.explainer.observe_next_tick()
        session.tick()
        self.session_view = after = session.view()
        robot = self.body.state.robots[session.agent]
        self.memory.append(float(robot["x"]), float(robot["y"]), after)
        presses = [example for example in session.examples[count_before:] if example.is_from_press]
        if presses:
            tone: Tone = "correction" if presses[0].correction else "recorded"
            self.status = StatusMessage(formatting.format_recorded_press(presses, self.features), tone)
            self.score.note_change()
        elif sentence := formatting.format_switch(self.name, before, after, driving=self.driving):
            self.status = StatusMessage(sentence)
        elif sentence := self.coach.describe_new_mark(marks):
            self.status = StatusMessage(sentence, "correction")
        if session.mode is Mode.LIVE and not self.driving:
            self.coach.quiet.note_tick(session.body.tick_s, flag=after.flag)
        if isinstance(self.body, BodyWorld) and self.body.is_over:
            self._pause_at_end(self.body)

    def _pause_at_end(self, body: BodyWorld) -> None:
        """Pause at the end of an episode, after which a body stays as it is."""
        if not self.paused:
            self.pause()
        self.status = StatusMessage(
            f"The episode is over after {body.time_s:.1f} s. Begin a new world, or reset this one"
        )

    @keep_status
    def pause(self) -> StatusMessage:
        """Pause or resume."""
        self.session.paused = not self.session.paused
        self._set_pace()
        return StatusMessage("Paused: . takes one step, space resumes" if self.paused else "Resumed")

    def step(self) -> None:
        """Take one tick, then pause."""
        if not self.session.paused:
            self.pause()
        if self.driving and self.steering is None:
            raise SessionError("no behavior is chosen for driving: press its key, or d to stop driving")
        self.pace.step()
        self.tick()

    def suspend(self, held: bool) -> None:
        """Suspend the run while the person reads something else, or end the suspension."""
        self.suspended = held
        self._set_pace()

    @keep_status
    def set_speed(self, speed: float) -> StatusMessage:
        """Set one of the available speeds."""
        self.pace.speed = check_speed(speed, "the trainer", live=self.pace.live)
        return StatusMessage(formatting.format_speed(speed))

    def _set_pace(self) -> None:
        stands = self.paused or self.suspended or (self.driving and self.steering is None)
        (self.pace.stop if stands else self.pace.resume)()

    @keep_status
    def faster(self) -> StatusMessage:
        """Change to the next higher speed."""
        self.pace.faster()
        return StatusMessage(formatting.format_speed(self.pace.speed))

    @keep_status
    def slower(self) -> StatusMessage:
        """Change to the next lower speed."""
        self.pace.slower()
        return StatusMessage(formatting.format_speed(self.pace.speed))

    # Pressing

    @keep_status
    def press(self, name: str) -> StatusMessage:
        """Direct the robot to a state; while driving, drive with a basic behavior."""
        if self.driving:
            return self._steer(name)
        correction = self.session_view.mode is Mode.TESTING
        self.session.direct(name)
        return self._pressed(correction, f"{self.session_view.state} → {name}", name)

    @keep_status
    def confirm(self) -> StatusMessage:
        """Confirm the current state."""
        if self.driving:
            raise SessionError("nothing is recorded while driving: press d to stop driving first")
        correction = self.session_view.mode is Mode.TESTING
        self.session.confirm()
        return self._pressed(correction, f"keep {self.session_view.state}", None)

    def _pressed(self, correction: bool, what: str, state: str | None) -> StatusMessage:
        if self.session_view.mode is Mode.LIVE and not self._noted_live:
            self.note(self.robot, step="teach")
            self._noted_live = True
        self.note(self.robot, state)
        self.coach.quiet.note_press()
        self.corrected = correction or (self.corrected and self.session_view.waiting is not None)
        self.session_view = self.session.view()
        then = " on the next tick" if self.paused else ""
        return StatusMessage(
            f"{'correction: ' if correction else ''}{what}{then}", "correction" if correction else ""
        )

    # Modes

    @keep_status
    def toggle_mode(self) -> StatusMessage:
        """Switch from teaching to testing, or back."""
        self._end_driving()
        self.corrected = False
        if self.session.mode is not Mode.TESTING:
            if not any(example.is_from_press for example in self.session.examples):
                raise SessionError(
                    "there is nothing to test yet: direct the robot with the keys of the states first"
                )
            self.session.test()
            self.note(self.robot, step="test")
            status = StatusMessage("Testing: the automaton decides. Press a state's key where it is wrong")
        elif self._options.live:
            self.session.teach()
            self.note(self.robot, step="teach")
            status = StatusMessage("Teaching: it decides, and learns from every press")
        else:
            self.session.train()
            self.note(self.robot, step="train")
            status = StatusMessage("Training: you decide")
        self._look()
        return status

    @keep_status
    def restart(self) -> StatusMessage:
        """Restart the automaton where the robot is."""
        self.session.restart()
        self.note(self.robot, step="restart")
        self._look()
        return StatusMessage(f"{self.name} restarted; nothing recorded")

    @keep_status
    def reset_world(self) -> StatusMessage:
        """Restart the same world."""
        if self.seed is None:
            raise SessionError("the seed of a resumed world is not known: n begins a new world")
        return self._world(self.seed, f"World {self.seed} from its beginning")

    @keep_status
    def new_world(self) -> StatusMessage:
        """Begin the world of the next seed."""
        return self._world(0 if self.seed is None else self.seed + 1, f"World {self.seed_after}")

    @property
    def seed_after(self) -> int:
        """The seed of the next world."""
        return 0 if self.seed is None else self.seed + 1

    def take_next_seeds(self, count: int) -> range:
        """Return the seeds of the next worlds, which a person is about to see: later tests leave these worlds out."""
        seeds = range(self.seed_after, self.seed_after + count)
        self.seen_seeds.update(seeds)
        return seeds

    @keep_status
    def load_world(self, seed: int) -> StatusMessage:
        """Begin the world of a seed."""
        return self._world(seed, f"World {seed}, from the start")

    def _world(self, seed: int, what: str) -> StatusMessage:
        self._end_driving()
        self.session.reset(seed)
        self.coach.quiet.begin_situation()
        self.seed = seed
        self.memory.clear()
        self.explainer.clear()
        self._look()
        so_far = f". {self.coach.quiet.sentence}" if self.coach.quiet.count else ""
        return StatusMessage(f"{what}; nothing recorded{so_far}")

    @keep_status
    def toggle_watching(self) -> StatusMessage:
        """Turn learning from silence off or on."""
        if not self.can_watch:
            raise SessionError("this lesson records presses only: turn on learning from silence with c first")
        self.session.is_watching = not self.session.is_watching
        return StatusMessage(
            "Learning from silence: on" if self.session.is_watching else "Learning from silence: off"
        )

    @keep_status
    def toggle_score(self) -> StatusMessage:
        """Turn the score in new worlds off or on."""
        self.score.turn(not self.score.enabled)
        return StatusMessage(f"Runs in new worlds after each press: {'on' if self.score.enabled else 'off'}")

    @keep_status
    def keep_going(self) -> StatusMessage:
        """Test what is in training in new worlds, and go to where it goes wrong."""
        return self.continuation.finish(self.continuation.begin()())

    @keep_status
    def go_back(self) -> StatusMessage:
        """Undo what was done since the best version that was tested, and go to where that one goes wrong."""
        return self.continuation.go_back()

    @keep_status
    def cycle_targets(self) -> StatusMessage:
        """Bind the parameters to the next targets."""
        parameters, targets = self.session.automaton.parameters, tuple(self.body.targets)
        if not parameters:
            raise SessionError(f"{self.name} has no parameters")
        ways = list(product(targets, repeat=len(parameters)))
        now = tuple(self.session_view.targets[parameter] for parameter in parameters)
        way = ways[(ways.index(now) + 1) % len(ways)]
        return self.bind_targets(dict(zip(parameters, way, strict=True)))

    @keep_status
    def bind_targets(self, targets: Mapping[str, str]) -> StatusMessage:
        """Bind parameters to these targets."""
        self.session.bind_targets(**targets)
        self.memory.clear()
        self._look()
        return StatusMessage(f"Now {formatting.format_targets(self.session_view)[1:-1]}")

    @keep_status
    def note_moved(self, what: str) -> StatusMessage:
        """Report that something in the world was moved by hand."""
        self.session.note_moved()
        self.memory.clear()
        self.explainer.clear()
        self._look()
        return StatusMessage(f"{what}; nothing recorded")

    # Driving into position

    @keep_status
    def drive(self) -> StatusMessage:
        """Begin or end driving the robot into position; nothing is recorded."""
        if self.driving:
            self._end_driving()
            return StatusMessage(f"Driving ended; {self.name} continues in {self.session_view.state}")
        self.driving, self.steering = True, None
        self._set_pace()
        return StatusMessage("Drive it into position with the same keys; d ends it. Nothing is recorded")

    def _steer(self, name: str) -> StatusMessage:
        self.steering = None if name == self.steering else name
        if self.steering is not None:
            self.session.drive(name)
            self.explainer.clear()
        self._set_pace()
        return StatusMessage(
            f"Driving: {name} (the same key stops it)" if self.steering else "Driving: the robot stands still"
        )

    def _end_driving(self) -> None:
        if self.driving:
            self.driving, self.steering = False, None
            self.session.drive(None)
            self._set_pace()
            self._look()

    # The lesson

    @keep_status
    def undo(self) -> StatusMessage:
        """Undo a waiting press, or the last change of the lesson."""
        return self._changed(f"Undone: {self.session.undo()}")

    @keep_status
    def redo(self) -> StatusMessage:
        """Redo the change that was undone last."""
        return self._changed(f"Redone: {self.session.redo()}")

    @keep_status
    def delete(self, number: int) -> StatusMessage:
        """Delete an example."""
        self.session.delete(number)
        return self._changed(f"Example {number} deleted; undo reverts this")

    @keep_status
    def edit(self, number: int, **what: Unpack[ExampleChange]) -> StatusMessage:
        """Change the state, next state or values of an example."""
        self.session.edit(number, **what)
        return self._changed(f"Example {number} edited; undo reverts this")

    @keep_status
    def change_design(self, choices: LessonChoices) -> StatusMessage:
        """Change the design of the lesson; examples are kept if possible."""
        for flag in choices.flags or ():
            if flag not in self.session.automaton.flags:
                check_new_name(flag, "a flag")
        meant = self.score.goal
        self.session.change_design(**choices.to_design_change(self._options))
        self.memory.clear()
        self.note_lesson_change()
        means = self.score.goal
        meaning = "" if means == meant else f". Success is now: {means or 'not chosen'}"
        return StatusMessage(f"Design changed; the examples are kept, and undo reverts this{meaning}")

    @keep_status
    def save(self) -> StatusMessage:
        """Save the automaton and keep its former version; report outcomes that are lost, and what others saved."""
        taught, library = self.session.make_trained_automaton(), self.session.library
        worse = find_regressions_since_saved(self.folder, library, taught)
        others = self._saved.list_library_changes(library, taught.automaton)
        changed = self.change_to_save
        path = self.save_unchecked(taught)
        sentence = formatting.format_saved_message(path, worse, others, changed)
        return StatusMessage(sentence, "error" if worse or others else "recorded")

    def save_unchecked(self, taught: TrainedAutomaton) -> Path:
        """Save the automaton to the library and keep its former version, without checking its outcomes."""
        return self._saved.save(taught)

    def _changed(self, sentence: str) -> StatusMessage:
        self.note_lesson_change()
        return StatusMessage(sentence)

    def note_lesson_change(self) -> None:
        """Update the view and the score after a change of what is learned from."""
        self.refresh_view()
        self.score.note_change()

    def refresh_view(self) -> None:
        """Update the view after a change of the lesson."""
        self._look()
        self._redraw_keys()
        self._options = self.session.lesson.options
        self.corrected = False

    def _look(self) -> None:
        self.session_view = self.session.view()
