"""The parts of the teaching screen as text. Words and marks carry all information; colors only repeat it."""

from __future__ import annotations

from collections.abc import Sequence

from rich.text import Text

from understudy.model import describe
from understudy.model.lesson import Example, ExampleKind
from understudy.model.plain_names import format_names
from understudy.training.trainee import Mode
from understudy.ui.controller import formatting
from understudy.ui.controller.clock import FASTEST
from understudy.ui.controller.trainer import Trainer

TITLE, DIM = "bold underline", "dim"
LIT = "bold reverse"
MODES = {Mode.TRAINING: "bold reverse", Mode.TESTING: "bold reverse green", Mode.LIVE: "bold reverse green"}
CORRECTED, DRIVING = "bold reverse magenta", "bold reverse yellow"
TONES = {"": "", "recorded": "green", "correction": "bold magenta", "error": "bold red"}
MARKS = {"": "·", "recorded": "●", "correction": "◆", "error": "!"}
CHANGED = "±"

COMMANDS = (
    ("t", "try"), ("enter", "confirm"), ("u", "undo"), ("U", "redo"), ("space", "pause"),
    (".", "step"), ("+−", "speed"), ("n", "world"), ("r", "restart"), ("d", "drive"), ("p", "target"),
    ("w", "silence"), ("M", "new worlds"), ("T", "keep going"), ("l", "lesson"), ("c", "choose"),
    ("?", "why"), ("s", "save"), ("q", "quit"), ("h", "help"),
)  # fmt: skip
SPARE = "MTcwU"
"""Keys left to the page of help, first to last, where two lines do not hold all of them."""


def render_header(trainer: Trainer, width: int) -> Text:
    """Render the automaton, the mode, and the state of the session."""
    view = trainer.session_view
    targets = format_names(formatting.format_targets(view))
    left = Text.assemble((f" {format_names(trainer.name)}", "bold"), targets, " ")
    if trainer.driving:
        left.append(" DRIVING ", DRIVING)
    elif trainer.corrected:
        left.append(" CORRECTED ", CORRECTED)
        left.append(" t: try again", CORRECTED.replace("reverse ", ""))
    else:
        left.append(f" {view.mode.name} ", MODES[view.mode])
    if trainer.paused:
        left.append(" ")
        left.append(" PAUSED ", LIT)
    count = view.examples
    right = Text.assemble(
        f"{count} example{'s' * (count != 1)}  {formatting.format_minutes(view.time_s)}  "
        f"{'fastest' if trainer.pace.speed == FASTEST else f'{trainer.pace.speed:g}×'}  ",
        ("unsaved ", "bold") if trainer.has_unsaved_changes else ("saved " if count else ""),
    )
    left.truncate(max(0, width - right.cell_len - 1))
    left.pad_right(max(1, width - left.cell_len - right.cell_len))
    return left + right


def render_states(trainer: Trainer, width: int) -> Text:
    """Render the states with their keys, the active one highlighted; while driving, the basic behaviors."""
    if trainer.driving:
        return _drivers(trainer, width)
    view = trainer.session_view
    what = "press to direct" if view.mode is Mode.TRAINING else "press to correct"
    lines = [_title("States", what, width)]
    for state in trainer.session.automaton.states:
        active = state.name == view.state
        runs = "" if state.flag is not None or state.behavior is None else str(state).removeprefix(state.name)
        about = "raises a flag" if state.flag is not None else "idles" if state.behavior is None else runs
        if active and len(view.path) > 1:
            about = " > ".join(("", *view.path[1:])).strip()
        mark = "▶" if active else "…" if state.name == view.waiting else " "
        flag = " ⚑" if state.flag is not None else ""
        line = Text.assemble(
            (f"{trainer.keys.label(state.name)} ", "bold"),
            f"{mark} ",
            (f" {format_names(state.name)}{flag} ", LIT if active else ""),
        )
        line.append(f" {format_names(about)}" if about else "", "" if active else DIM)
        line.truncate(width, overflow="ellipsis")
        lines.append(line)
    return Text("\n").join(lines)


def _drivers(trainer: Trainer, width: int) -> Text:
    lines = [_title("Drive", "into position; d ends it", width)]
    for behavior in trainer.drivers:
        active = behavior.name == trainer.steering
        line = Text.assemble(
            (f"{trainer.drive_keys.label(behavior.name)} ", "bold"),
            "▶ " if active else "  ",
            (f" {format_names(behavior.name)} ", LIT if active else ""),
        )
        lines.append(line)
    return Text("\n").join(lines)


def render_readings(trainer: Trainer, width: int) -> Text:
    """Render the present features with their units and recent values."""
    lines = [_title("Readings", "", width)]
    labels = [str(bound) for bound in trainer.features]
    names = list(map(format_names, labels))
    wide = max(map(len, names), default=0)
    for label, name, bound in zip(labels, names, trainer.features, strict=True):
        now = describe.format_value(bound, trainer.session_view.features[label])
        room = width - wide - 13
        bars = formatting.format_sparkline(bound, trainer.memory.readings(label), room) if room >= 4 else ""
        lines.append(Text.assemble(f"{name:<{wide}} ", (f"{now:>10}", "bold"), (f"  {bars}", "cyan")))
        lines[-1].truncate(width)
    if not labels:
        lines.append(Text("none chosen: press c", DIM))
    return Text("\n").join(lines)


def render_examples(trainer: Trainer, width: int, height: int) -> Text:
    """Render the last examples, newest first, a line for each press."""
    pressed = [example for example in trainer.session.examples if example.is_from_press]
    watched = len(trainer.session.examples) - len(pressed)
    note = f"{len(pressed)} shown" + (f", {watched} watched" if watched else "")
    lines = [_title("Examples", note if trainer.session.examples else "", width)]
    if not pressed:
        return lines[0] + Text(
            "\nNo examples yet. Press the key of a state: what the robot senses then, and that state, "
            "become an example. Then press t to test what it learned.",
            DIM,
        )
    presses = list(reversed(_presses(pressed)))[: max(0, height - 1)]
    if not presses:
        return lines[0]  # no room for any
    numbers_of = [
        [
            describe.format_value(*pair, unit=False)
            for pair in zip(trainer.features, press[0].values, strict=True)
        ]
        for press in presses
    ]
    wides = [max(map(len, column)) for column in zip(*numbers_of, strict=True)]
    steps = [format_names(formatting.format_example(press[0])) for press in presses]
    wide = max(map(len, steps))
    digits = len(str(presses[0][0].number))
    for press, step, numbers in zip(presses, steps, numbers_of, strict=True):
        aligned = "  ".join(f"{text:>{column}}" for text, column in zip(numbers, wides, strict=True))
        mark, style = _mark(press)
        number = f"{press[0].number:>{digits}}"
        lines.append(Text.assemble((number, DIM), (f"{mark} ", style), f"{step:<{wide}}  ", (aligned, DIM)))
        lines[-1].truncate(width, overflow="ellipsis")
    return Text("\n").join(lines)


def _mark(press: Sequence[Example]) -> tuple[str, str]:
    """Return the mark of a correction, a switch with its default, or a confirmation, with its style."""
    first = press[0]
    if first.correction:
        return "◆", TONES["correction"]
    return "+" if len(press) > 1 else "=" if first.state == first.next else " ", ""


def _presses(examples: Sequence[Example]) -> list[list[Example]]:
    """Group examples by press: a default belongs to the directive before it."""
    presses: list[list[Example]] = []
    for example in examples:
        if example.kind is ExampleKind.DEFAULT and presses and presses[-1][-1].number == example.number - 1:
            presses[-1].append(example)
        else:
            presses.append([example])
    return presses


def render_explanation(trainer: Trainer, width: int) -> Text:
    """Render the explanation of the present decision."""
    lines = [_title("Why?", "? shows the examples again", width)]
    lines += [Text(format_names(line)) for line in trainer.explainer.format_lines(trainer.session_view)]
    return Text("\n").join(lines)


def render_changes(trainer: Trainer, width: int) -> Text:
    """Render what the last press or edit changed: each decision with its former and its present conditions."""
    lines = [_title("What changed", "D shows the examples again", width)]
    summary = trainer.session.last_change
    for change in () if summary is None else summary.changes:
        gone, new = change.list_differences()
        lines.append(Text(format_names(change.said), "bold"))
        lines += [Text(f"  − {format_names(when)}", "red") for when in gone]
        lines += [Text(f"  + {format_names(when)}", "green") for when in new]
    return Text("\n").join(lines)


def render_status(trainer: Trainer) -> Text:
    """Render the status, the decisions that the last press or edit changed elsewhere, and the score in new worlds."""
    tone, score, change = trainer.status.tone, trainer.score, trainer.session.last_change
    text = Text(f" {MARKS[tone]} {format_names(trainer.status.text)}", TONES[tone])
    if (better := trainer.continuation.better) is not None:
        text.append("  B", "bold").append(f" undo {better.since}", DIM)
    if change is not None:
        text.append(f"\n {CHANGED} Changed: {format_names(str(change))}", "bold yellow")
        text.append("  u", "bold").append(" undo", DIM).append("  D", "bold").append(" show me", DIM)
    sentence = score.describe()
    if sentence and score.offers:
        sentence += f". Success: {score.goal or score.offers[0].name + ' (S chooses)'}"
    if sentence:
        text.append(f"\n   {format_names(sentence)}", TONES["error"] if score.trend == "falling" else DIM)
    return text


def render_commands(trainer: Trainer, width: int) -> Text:
    """Render the keys of the commands, in two lines if that is possible."""
    useless = {"p" if not trainer.session.automaton.parameters else "", "" if trainer.can_watch else "w"}
    named = {"t": "teach"} if trainer.session_view.mode is Mode.TESTING else {}
    commands = [(key, named.get(key, what)) for key, what in COMMANDS if key not in useless]
    for spare in SPARE:
        if len(lines := _lines(commands, width)) <= 2:
            break
        commands = [command for command in commands if command[0] != spare]
    else:
        lines = _lines(commands, width)
    return Text("\n").join(lines)


def _lines(commands: Sequence[tuple[str, str]], width: int) -> list[Text]:
    lines = [Text("")]
    for key, what in commands:
        if lines[-1].cell_len + len(key) + len(what) + 2 > width:
            lines.append(Text(""))
        lines[-1].append(f" {key}", "bold").append(f" {what} ", DIM)
    return lines


def _title(title: str, note: str, width: int) -> Text:
    text = Text.assemble((title, TITLE), ("  " + note if note else "", DIM))
    text.truncate(width, overflow="ellipsis")
    return text
