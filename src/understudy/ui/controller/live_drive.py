"""A drive under way: a simulated robot is driven with a stick, and the labels of the drive follow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from math import nan
from threading import Lock
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.candidates import BehaviorCandidate, Candidate
from understudy.addons.recordings.drive_recorder import DriveRecorder
from understudy.addons.recordings.segment import Segmentation, segment
from understudy.clock import REAL_TIME
from understudy.errors import SessionError
from understudy.model.features import BoundFeature, Percept
from understudy.records.record import POSE, Record
from understudy.runtime.feature_columns import read_feature_column
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import IDLE_PROGRAM, link
from understudy.runtime.run_loop import Run
from understudy.sim.body_world import BodyWorld
from understudy.sim.world import World
from understudy.ui.controller.clock import RealTimeClock
from understudy.ui.controller.recording_review import RecordingReview
from understudy.ui.controller.status import describe_error
from understudy.ui.controller.stick import AT_REST, StickLayout, StickPosition

DrivenWorld: TypeAlias = World | BodyWorld
"""The worlds in which a person can drive: simulated ones, and those of bodies of the user's own."""
SILENT_S = 0.3
"""How long after the last message about the stick it counts as at rest, s."""
EVERY_S = 1.0
"""The least time between two segmentations during a drive, s."""
MOST_SHARE = 0.25
"""The share of the time that segmenting takes at most; a long drive is segmented less often."""
OVER = "the episode is over: begin a new world to go on"


class DriveExplanation(NamedTuple):
    """What explains a drive: candidates, and the features that the driver's switches may depend on."""

    candidates: Sequence[Candidate]
    features: Sequence[BoundFeature]


class LiveDrive:
    """The drive of one robot of a world by a stick, from which its review grows.

    The world stands still until the stick is moved, so that no drive begins with a wait. It also stands still whenever
    the stick is at rest, unless one of the behaviors rests: nothing else could explain that. The automaton that was
    learned can drive, too, until the stick is moved; this is no part of the drive. Everything but the segmentation,
    which runs in a thread, happens in the thread of the caller.

    Parameters
    ----------
    world
        The world.
    layout
        What the stick commands.
    explanation
        What explains the drive.
    make_review
        The function that makes the review of the first segmentation.
    agent
        The robot that is driven, from 0; the others rest.
    keep
        A function that keeps a drive that was paused, in files; None: it is not kept.
    wall
        The clock of real time.
    """

    def __init__(
        self,
        world: DrivenWorld,
        layout: StickLayout,
        explanation: DriveExplanation,
        make_review: Callable[[Segmentation], RecordingReview],
        *,
        agent: int = 0,
        keep: Callable[[Record], None] | None = None,
        wall: Callable[[], float] = REAL_TIME,
    ) -> None:
        self.world, self.layout, self.agent = world, layout, agent
        self.driving = False
        """True from the beginning of a drive until it is paused."""
        self.waiting = False
        """True while the world stands still until the stick is moved."""
        self.automatic = False
        """True while the automaton that was learned drives, until it is paused or the stick is moved."""
        self.review: RecordingReview | None = None
        """The review of what was segmented so far; None before the first segmentation."""
        self.lock = Lock()
        """Held while the review is read in another thread, or changed."""
        self.error = ""
        """The sentence of the last problem; empty if there is none."""
        self.version = 0
        """Grows whenever the review changes."""
        self._explanation, self._make_review, self._keep, self._wall = explanation, make_review, keep, wall
        self._can_rest = any(_rests(each, layout) for each in explanation.candidates)
        self._pace = RealTimeClock(wall, tick_s=world.tick_s)
        self._recorder = DriveRecorder(world, self._name_episode())
        self._stick, self._heard_s = AT_REST, -SILENT_S
        self._executor = ThreadPoolExecutor(1, thread_name_prefix="segment")
        self._running: Future[Segmentation] | None = None
        self._segmented, self._kept, self._began_s, self._due_s = 0, 0, 0.0, 0.0
        self._refined = True
        self._run: Run | None = None
        self._has_moved = False  # since the last tick of the drive, by itself
        self.percept: Percept = world.sense(self._recorder.keys)
        """The present readings of all robots."""

    @property
    def ticks(self) -> int:
        """The number of ticks that were driven."""
        return self._recorder.ticks

    @property
    def is_current(self) -> bool:
        """Whether the review has all ticks that were driven."""
        return self._running is None and self._segmented == self.ticks and self._refined

    @property
    def stick(self) -> StickPosition:
        """The position of the stick; at rest if nothing was heard of it for `SILENT_S`."""
        return self._stick if self._wall() - self._heard_s < SILENT_S else AT_REST

    def find_review(self) -> RecordingReview:
        """Return the review; SessionError before the first segmentation."""
        if self.review is None and self.ticks:
            raise SessionError("the labels are being found: ask again in a moment")
        if self.review is None:
            raise SessionError("nothing was driven yet: move the stick")
        return self.review

    def check_change(self) -> None:
        """Raise SessionError while the robot moves, or while labels are being found."""
        if self.driving or self.automatic or not self.is_current:
            raise SessionError("the drive goes on: pause it, and then change its labels")

    def list_places(self) -> NDArray[np.float64]:
        """List where the robot was at each tick of the review [T, 2], m; NaN where that is not known."""
        count = 0 if self.review is None else self.review.segmentation.drive.ticks
        return self._recorder.list_places()[:count]

    def list_readings(self, features: Sequence[BoundFeature]) -> list[float]:
        """List the present values of features of the driven robot."""
        agents = self.world.agents
        return [
            float(read_feature_column(each, self.percept, agents=agents)[self.agent]) for each in features
        ]

    def steer(self, stick: StickPosition) -> None:
        """Take the position of the stick, which holds until the next one, or for `SILENT_S`."""
        self._stick, self._heard_s = stick, self._wall()

    def drive(self) -> None:
        """Begin to drive, or go on; the world waits for the stick. SessionError while the review is being changed."""
        if self.driving:
            return
        self._check_start()
        if self.automatic:
            self.pause()
        self.error, self._stick = "", AT_REST
        self.driving = self.waiting = True

    def let_automaton_drive(self) -> None:
        """Let the automaton that was learned drive until it is paused, or the stick is moved.

        SessionError is raised while the robot is driven, or if nothing was learned from the present labels.
        """
        if self.automatic:
            return
        if self.driving:
            raise SessionError("the robot is being driven: pause first")
        self._check_start()
        learned = None if self.review is None else self.review.learned
        if learned is None:
            raise SessionError("no automaton was learned from these labels: learn first")
        library = learned.drive.library.with_automaton(learned.taught)
        program, now = link(library, learned.taught.automaton.name), self.world.time_s
        members = [Interpreter(IDLE_PROGRAM, now=now) for _ in range(self.world.agents)]
        members[self.agent] = Interpreter(program, now=now)
        self._run = Run(self.world, members)
        self.error, self._stick = "", AT_REST
        self.automatic = self._has_moved = True
        self._pace.resume()

    def find_automaton_state(self) -> str:
        """Return the state of the automaton that drives; empty if none does."""
        return "" if self._run is None or not self.automatic else self._run.path(self.agent)[0]

    def _check_start(self) -> None:
        """Raise SessionError if the robot must not move now."""
        if self.lock.locked():
            raise SessionError("the labels are being learned from: drive on when that is done")
        if isinstance(self.world, BodyWorld) and self.world.is_over:
            raise SessionError(OVER)

    def pause(self) -> None:
        """Pause; what was driven is segmented to its end, and kept."""
        if self.automatic:
            self.automatic, self._stick = False, AT_REST
            self._pace.stop()
        if not self.driving:
            return
        self.driving = self.waiting = False
        self._stick = AT_REST
        self._pace.stop()
        self._due_s = 0.0
        if self.review is not None:
            self.review.is_growing = False
            self.version += 1
        if self._keep is not None and self.ticks > self._kept:
            self._kept = self.ticks
            try:
                self._keep(self._recorder.make_drive())
            except Exception as error:  # a full disk, or a folder that cannot be written
                self.error = describe_error(error)

    def begin_world(self, seed: int) -> None:
        """Begin another world, as another episode of the drive; SessionError while the robot is driven."""
        if self.driving or self.automatic:
            raise SessionError("the robot is under way: pause first")
        self.world.reset([seed])
        self.percept = self.world.sense(self._recorder.keys)
        self._has_moved = False
        self._recorder.begin_episode(self._name_episode())

    def advance(self) -> int:
        """Take the ticks that are due, and segmentations that ended; return the number of ticks."""
        taken = 0
        if self.automatic and not self.stick.is_resting:
            self.automatic, self.driving = False, True  # the person takes over
        if self.automatic:
            for _ in self._pace.ticks():
                self._tick_automaton()
                taken += 1
                if not self.automatic:
                    break
        elif self.waiting and not self._waits():
            self.waiting = False
            self._pace.resume()
            self._tick()
            taken = 1
        elif self.driving and not self.waiting:
            for _ in self._pace.ticks():
                if not self._can_rest and self._waits():
                    self.waiting = True
                    self._pace.stop()
                    break
                self._tick()
                taken += 1
                if not self.driving:
                    break
        self._advance_segmentation()
        return taken

    def _waits(self) -> bool:
        """Return whether the stick is at rest, or leans where it commands nothing that a behavior could explain."""
        stick = self.stick
        if stick.is_resting or self._can_rest:
            return stick.is_resting
        return self.layout.make_command(stick) == self.layout.make_command(AT_REST)

    def close(self) -> None:
        """Pause, and wait for a segmentation that is running."""
        self.pause()
        self._executor.shutdown(cancel_futures=True)

    def _tick(self) -> None:
        """Give the command of the stick for one tick, and record it."""
        try:
            if self._has_moved:
                self._recorder.begin_episode(f"{self._name_episode()} from {self.world.time_s:.1f} s")
                self._has_moved = False
            command = self.layout.make_command(self.stick)
            readings = [float(self.percept[key][self.agent]) for key in self._recorder.keys]
            self.world.act(
                {
                    channel.name: self._make_column(value, channel.rest)
                    for channel, value in zip(self.layout.channels, command, strict=True)
                }
            )
            self.percept = self.world.sense(self._recorder.keys)
            self._recorder.add(self.world.time_s, readings, command, self._find_pose())
        except Exception as error:  # of a body of the user's own
            self.pause()
            self.error = describe_error(error)
        self._pause_at_end()

    def _tick_automaton(self) -> None:
        """Let the automaton give the command of one tick, which is not recorded."""
        try:
            if self._run is not None:
                self.world.act(self._run.decide(self.percept))
                self.percept = self.world.sense(self._recorder.keys)
        except Exception as error:  # of a body or a behavior of the user's own
            self.pause()
            self.error = describe_error(error)
        self._pause_at_end()

    def _pause_at_end(self) -> None:
        if isinstance(self.world, BodyWorld) and self.world.is_over:
            self.pause()
            self.error = OVER

    def _make_column(self, value: float, rest: float) -> NDArray[np.float64]:
        column = np.full(self.world.agents, rest)
        column[self.agent] = value
        return column

    def _find_pose(self) -> list[float]:
        if isinstance(self.world, BodyWorld):
            return [nan] * len(POSE)
        return [float(self.world.state.robots[name][self.agent]) for name in POSE]

    def _name_episode(self) -> str:
        return f"seed {self.world.seeds[0]}"

    def _advance_segmentation(self) -> None:
        """Take over a segmentation that ended, and begin one if it is due."""
        now = self._wall()
        if self._running is not None and self._running.done():
            running, self._running = self._running, None
            self._due_s = now + max(EVERY_S, (now - self._began_s) / MOST_SHARE) if self.driving else 0.0
            self.version += 1
            try:
                self._take(running.result())
            except Exception as error:  # a candidate of the user's own may do anything
                self.error = describe_error(error)
                self.pause()
        unfinished = self._segmented < self.ticks or not (self._refined or self.driving)
        if self._running is None and unfinished and now >= self._due_s:
            drive = self._recorder.make_drive()
            # When the driver switches is learned at a pause only: meanwhile labels are to come quickly.
            features = () if self.driving else self._explanation.features
            self._refined = not self.driving or not self._explanation.features
            self._segmented, self._began_s = drive.ticks, now
            defined = () if self.review is None else self.review.new_candidates
            candidates = [*self._explanation.candidates, *defined]
            self._running = self._executor.submit(segment, drive, candidates, features=features)

    def _take(self, segmentation: Segmentation) -> None:
        with self.lock:
            if self.review is None:
                self.review = self._make_review(segmentation)
            else:
                self.review.extend(segmentation)
            self.review.is_growing = self.driving


def _rests(candidate: Candidate, layout: StickLayout) -> bool:
    """Return whether a candidate is a basic behavior that leaves all channels at rest."""
    if not isinstance(candidate, BehaviorCandidate) or candidate.ground.behavior.function is not None:
        return False
    rest = {each.name: each.rest for each in layout.channels}
    return all(value == rest.get(channel) for channel, value in candidate.ground.behavior.command.items())
