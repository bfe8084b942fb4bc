"""The teaching screen: the world, the states with their keys, readings, examples, and the status."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import ClassVar, Literal

from rich.text import Text
from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import Screen
from textual.widgets import Static
from textual.worker import get_current_worker

from understudy.addons.robots.arming_order import ArmingOrder
from understudy.clock import REAL_TIME
from understudy.errors import UnderstudyError
from understudy.model.plain_names import format_names
from understudy.sim.body_world import BodyWorld
from understudy.ui.controller.arming import RobotArming
from understudy.ui.controller.coach import go_to_next_situation, set_up_advised_situation, skip_ahead
from understudy.ui.controller.lesson_actions import choose_next_goal
from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.trainer import Trainer
from understudy.ui.controller.training_plan import LessonChoices
from understudy.ui.terminal import panels
from understudy.ui.terminal.advice_screen import AdviceScreen
from understudy.ui.terminal.body_readings import render_body_readings
from understudy.ui.terminal.dialogs import HelpScreen, QuestionDialog
from understudy.ui.terminal.lesson_form import LessonForm
from understudy.ui.terminal.lesson_screen import LessonScreen
from understudy.ui.terminal.world_view import describe_followed_robot, fit_arena, render_world

BEAT_S = 1 / 30
LEAST_SIDE = 38
"""Columns beside the world."""

WIDE = 110
"""Columns from which one line is enough to say what was recorded."""

ACTIONS: Mapping[str, Callable[[Trainer], object]] = {
    "t": Trainer.toggle_mode, "enter": Trainer.confirm, "u,ctrl+z": Trainer.undo, "U,ctrl+y": Trainer.redo,
    "space": Trainer.pause, "full_stop": Trainer.step, "plus,equals_sign": Trainer.faster, "minus": Trainer.slower,
    "r": Trainer.restart, "R": Trainer.reset_world, "n": Trainer.new_world, "d": Trainer.drive,
    "w": Trainer.toggle_watching, "p": Trainer.cycle_targets, "M": Trainer.toggle_score, "T": Trainer.keep_going,
    "B": Trainer.go_back, "S": choose_next_goal, "C": set_up_advised_situation, "F": skip_ahead,
    "G": go_to_next_situation,
}  # fmt: skip
"""What keys do with the trainer."""


class TeachingScreen(Screen[str]):
    """The screen for teaching a robot. It returns "quit"."""

    CSS = """
    TeachingScreen { layout: vertical; }
    #header { height: 1; }
    #middle { height: 1fr; }
    #world { width: 40; height: 100%; border: round ansi_default; border-title-align: left; }
    #side { width: 1fr; padding: 0 1; }
    #states, #readings { height: auto; }
    #readings { margin-top: 1; }
    #lower { height: 1fr; margin-top: 1; }
    .tight #readings, .tight #lower { margin-top: 0; }
    #said { height: auto; min-height: 2; max-height: 6; }
    TeachingScreen.wide #said { min-height: 1; }
    #keys { height: auto; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        *(Binding(keys, f"trainer('{keys}')", show=False) for keys in ACTIONS),
        Binding("s", "save", show=False),
        Binding("question_mark", "show('why')", show=False),
        Binding("D", "show('changes')", show=False),
        Binding("l", "lesson", show=False),
        Binding("A", "ask", show=False),
        Binding("y", "arm", show=False),
        Binding("backspace", "stop", show=False),
        Binding("K", "advice", show=False),
        Binding("W", "failures", show=False),
        Binding("c", "choose", show=False),
        Binding("h,f1", "help", show=False),
        Binding("q,ctrl+c", "leave", show=False),
    ]

    def __init__(
        self,
        trainer: Trainer,
        *,
        show_failures: Callable[[], object] | None = None,
        wall: Callable[[], float] = REAL_TIME,
    ) -> None:
        super().__init__()
        self.trainer, self._wall = trainer, wall
        self._show_failures = show_failures
        self.robots = RobotArming(trainer.body, wall, place="the terminal")
        self.lower: Literal["examples", "why", "changes"] = "examples"
        self._is_arming = False
        self._drawn: dict[str, Text] = {}

    def compose(self) -> ComposeResult:
        """Lay out the parts, top to bottom."""
        yield Static(id="header")
        with Horizontal(id="middle"):
            yield Static(id="world")
            with Vertical(id="side"):
                for name in ("states", "readings", "lower"):
                    yield Static(id=name)
        yield Static(id="said")
        yield Static(id="keys")

    def on_mount(self) -> None:
        """Start the world."""
        self.trainer.suspend(False)
        self.set_interval(BEAT_S, self.run_due_ticks)
        self.call_after_refresh(self.draw)

    def on_unmount(self) -> None:
        """Disarm real robots, and cancel arming under way, when the person leaves."""
        self.robots.disarm("the person left the terminal")

    def on_screen_suspend(self) -> None:
        """Suspend the world while another screen lies on top."""
        self.trainer.suspend(True)

    def on_screen_resume(self) -> None:
        """Resume the world."""
        self.trainer.suspend(False)
        self.draw()

    def on_resize(self) -> None:
        """Draw in the new size."""
        self.call_after_refresh(self.draw)

    def run_due_ticks(self) -> None:
        """Take the ticks that are due, and show the result."""
        moved = False

        def go() -> None:
            nonlocal moved
            self.robots.refresh_heartbeat(holding=False)
            moved = self.trainer.run_due_ticks()
            if self.robots.idle():
                self.trainer.session.refresh_percept()
                moved = True

        if not self._guarded(go):
            self.robots.disarm(self.trainer.status.text)
            self.trainer.session.paused = True
            self.trainer.suspend(self.trainer.suspended)
        if moved:
            self.draw()

    def _guarded(self, action: Callable[[], object]) -> bool:
        """Run an action, and show an error as the status."""
        try:
            action()
        except UnderstudyError as error:
            self.trainer.status = StatusMessage(str(error), "error")
            self.draw()
            return False
        return True

    # Keys

    def on_key(self, event: events.Key) -> None:
        """Handle the keys of states, or of basic behaviors while driving."""
        keys = self.trainer.drive_keys if self.trainer.driving else self.trainer.keys
        name = keys.leads.get(event.character or "") or keys.leads.get(event.key)
        if name is not None:
            event.stop()
            event.prevent_default()
            self._act(lambda trainer: trainer.press(name))

    def action_trainer(self, keys: str) -> None:
        """Do what keys do with the trainer."""
        self._act(ACTIONS[keys])

    def _act(self, action: Callable[[Trainer], object]) -> None:
        self._guarded(lambda: action(self.trainer))
        self.draw()

    def action_save(self) -> None:
        """Save the automaton; ask first if it decides otherwise than the saved one beyond what was pressed."""
        changed = self.trainer.change_to_save
        if changed is None:
            self._act(Trainer.save)
            return
        question = f"Since {self.trainer.name} was last saved: {changed}."
        self.app.push_screen(QuestionDialog(question, {"s": "save", "escape": "not now"}), self._save)

    def _save(self, way: str | None) -> None:
        if way == "s":
            self._act(Trainer.save)

    def action_show(self, what: Literal["why", "changes"]) -> None:
        """Show the explanation, or what changed, in place of the examples, or show these again."""
        if what == "changes" and self.trainer.session.last_change is None:
            self.trainer.status = StatusMessage(
                "Nothing changed beyond what the last press or edit says itself"
            )
        else:
            self.lower = "examples" if self.lower == what else what
        self.draw()

    def action_ask(self) -> None:
        """Change what happens at uncertain decisions: pause and ask, mark, or neither."""
        self.trainer.status = StatusMessage(self.trainer.coach.cycle_query_policy())
        self.draw()

    def action_arm(self) -> None:
        """Order to arm real robots, so that they can move; it is carried out in another thread, and a stop wins."""

        def begin() -> None:
            if self._is_arming:
                self.trainer.status = StatusMessage("Arming has not ended yet. Press y again in a moment")
                return
            order = self.robots.order_arming()
            self._is_arming = True
            self.trainer.status = StatusMessage("Arming…")
            self.run_worker(lambda: self._carry_out(order), name="arm", thread=True)

        self._guarded(begin)
        self.draw()

    def _carry_out(self, order: ArmingOrder) -> None:
        """Carry out an order to arm, and show in the screen's thread how it ended."""
        problem: UnderstudyError | None = None
        try:
            order.carry_out()
        except UnderstudyError as error:
            problem = error

        def finish() -> None:
            if problem is not None:
                raise problem
            order.refuse_overtaken()
            self.trainer.session.refresh_percept()  # what it read before is old by now
            self.trainer.status = StatusMessage("Armed: the robot moves while time runs. Esc stops it")

        def show() -> None:
            self._is_arming = False
            self._guarded(finish)
            self.draw()

        if not get_current_worker().is_cancelled:  # as it is if the person has left
            self.app.call_from_thread(show)

    def action_stop(self) -> None:
        """Stop real robots at once."""
        if self.robots.has_robots:
            self.robots.stop("stopped in the terminal")
            self.trainer.status = StatusMessage("Stopped. y arms it again", "error")
            self.draw()

    def action_advice(self) -> None:
        """Show what the coach suggests, and what a check of the automaton finds."""
        self._guarded(self._show_advice)
        self.draw()

    def _show_advice(self) -> None:
        report = self.trainer.coach.compute_report()
        if report is not None:
            self.app.push_screen(AdviceScreen(report), self._advised)

    def _advised(self, sets_up: bool | None) -> None:
        if sets_up:
            self._act(set_up_advised_situation)

    def action_failures(self) -> None:
        """Show the failing worlds, one of which can be opened."""
        if self._show_failures is not None:
            self._guarded(self._show_failures)

    def replace_trainer(self, trainer: Trainer) -> None:
        """Go on with the trainer of another session."""
        self.trainer = trainer
        self.robots = RobotArming(trainer.body, self._wall, place="the terminal")
        self.lower = "examples"
        trainer.suspend(False)
        self.draw()

    def action_help(self) -> None:
        """Show the help page."""
        self.app.push_screen(HelpScreen())

    def action_lesson(self) -> None:
        """Show all examples and the learned conditions."""
        self.app.push_screen(LessonScreen(self.trainer))

    def action_choose(self) -> None:
        """Change states, features and options."""
        session = self.trainer.session
        self.app.push_screen(LessonForm.for_lesson(session.library, session.lesson), self._chosen)

    def _chosen(self, choices: LessonChoices | None) -> None:
        if choices is not None:
            self._act(lambda trainer: trainer.change_design(choices))

    def action_leave(self) -> None:
        """End the session; ask first if there are unsaved changes."""
        if not self.trainer.has_unsaved_changes:
            self.dismiss("quit")
            return
        changed = self.trainer.change_to_save
        since = "" if changed is None else f" Since it was last saved: {changed}."
        question = f"{self.trainer.name} has unsaved changes.{since}"
        ways = {"s": "save and quit", "x": "quit without saving", "escape": "continue teaching"}
        self.app.push_screen(QuestionDialog(question, ways), self._left)

    def _left(self, way: str | None) -> None:
        if way == "x" or (way == "s" and self._guarded(self.trainer.save)):
            self.dismiss("quit")

    # Drawing

    def draw(self) -> None:
        """Draw the present state; parts that did not change are left alone."""
        if not self.is_mounted or not self.query_one("#middle").size.height:
            return
        trainer, width = self.trainer, self.size.width
        self.set_class(width >= WIDE, "wide")
        self._show("header", panels.render_header(trainer, width))
        self._show("said", panels.render_status(trainer))
        self._show("keys", panels.render_commands(trainer, width))
        middle = self.query_one("#middle")
        lines = max(5, middle.size.height)
        if isinstance(trainer.body, BodyWorld):
            self._draw_body(trainer.body, lines)
            return
        world = self.query_one("#world", Static)
        view = trainer.view
        columns, tall = fit_arena(view, max(10, width - LEAST_SIDE - 4), lines - 2)
        world.styles.width, world.styles.height = columns + 2, tall + 2
        name = format_names(trainer.body.scenario.name)
        world.border_title = name if trainer.seed is None else f"{name} {trainer.seed}"
        if self.robots.has_robots:
            world.border_title = self._standing()
        world.border_subtitle = describe_followed_robot(view, columns, trainer.robot)
        drawn = render_world(
            view,
            trainer.memory.trail,
            trainer.list_target_places(),
            columns=columns,
            lines=tall,
            robot=trainer.robot,
        )
        self._show("world", drawn)
        self._draw_side(width - columns - 4, lines)

    def _draw_body(self, body: BodyWorld, lines: int) -> None:
        """Show the readings of a body of the user's own, which cannot be drawn here."""
        trainer, world = self.trainer, self.query_one("#world", Static)
        width = min(LEAST_SIDE, self.size.width // 2)
        world.styles.width, world.styles.height = width, lines
        world.border_title = body.name if trainer.seed is None else f"{body.name} {trainer.seed}"
        self._show("world", render_body_readings(body, trainer.session.agent, lines=lines - 2))
        self._draw_side(self.size.width - width - 2, lines)

    def _standing(self) -> str:
        """Return whether real robots are armed, and the key that changes it."""
        robot = self.robots.list_statuses()[self.trainer.robot]
        if not robot.armed:
            return f"{format_names(robot.name)}: not armed (y)"
        return f"{format_names(robot.name)}: {'stands' if robot.stopped else 'armed'} (Esc)"

    def _draw_side(self, width: int, lines: int) -> None:
        trainer = self.trainer
        states, readings = panels.render_states(trainer, width), panels.render_readings(trainer, width)
        used = states.plain.count("\n") + readings.plain.count("\n") + 2
        tight = lines - used < 12
        self.query_one("#side").set_class(tight, "tight")
        left = lines - used - (0 if tight else 2)
        self._show("states", states)
        self._show("readings", readings)
        if self.lower == "why":
            lower = panels.render_explanation(trainer, width)
        elif self.lower == "changes" and trainer.session.last_change is not None:
            lower = panels.render_changes(trainer, width)
        else:
            lower = panels.render_examples(trainer, width, left)
        self._show("lower", lower)

    def _show(self, name: str, text: Text) -> None:
        if self._drawn.get(name) != text:
            self._drawn[name] = text
            self.query_one(f"#{name}", Static).update(text)
