"""The form for a lesson's design: states, features, parameters with targets, flags, options."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import product
from typing import ClassVar, Self

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import Screen
from textual.widgets import Input, Label, OptionList, Static
from textual.widgets.option_list import Option

from understudy.errors import SettingError, UnderstudyError
from understudy.model.automaton import START, State
from understudy.model.binding import format_bound_name
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.model.plain_names import format_names
from understudy.training.edits import change_design
from understudy.ui.controller.training_plan import (
    LessonChoices,
    TrainingPlan,
    choose_targets,
    make_planned_lesson,
)

NEW = (
    "Choose states (what it can do) and features (what it decides on): space selects, tab moves on, "
    "ctrl+g begins, esc cancels. With a parameter such as A it is taught once and works for any target."
)
AGAIN = "Change the design: space selects, tab moves on, ctrl+g applies, esc cancels."
REACTION_S = "0"
CONSENT = "learn from silence: what I watch without pressing is right"


class MultiSelect(OptionList):
    """A list of texts of which several can be selected."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("space", "select", show=False)]

    def __init__(self, *, id: str) -> None:
        super().__init__(id=id, compact=True)
        self._texts: list[str] = []
        self._chosen: set[str] = set()

    @property
    def selection(self) -> list[str]:
        """The selected texts, in the order of the list."""
        return [text for text in self._texts if text in self._chosen]

    def show_choices(self, texts: Iterable[str], *, chosen: Sequence[str]) -> None:
        """Show these texts, with some selected."""
        self._texts, self._chosen = list(texts), set(chosen)
        self.clear_options()
        self.add_options([Option(self._prompt(text)) for text in self._texts])
        self.highlighted = 0 if self._texts else None  # so that space chooses at once

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Select or deselect an option."""
        event.stop()
        text = self._texts[event.option_index]
        self._chosen ^= {text}
        self.replace_option_prompt_at_index(event.option_index, self._prompt(text))

    def _prompt(self, text: str) -> Text:
        mark, style = ("[x]", "bold") if text in self._chosen else ("[ ]", "")
        return Text.assemble((f"{mark} {format_names(text)}", style))


Check = Callable[[LessonChoices], object]


class LessonForm(Screen[LessonChoices | None]):
    """The form; it returns the choices, or None if it was cancelled."""

    CSS = """
    LessonForm { layout: vertical; padding: 0 1; }
    LessonForm #lists { height: 1fr; min-height: 6; }
    LessonForm .list { width: 1fr; }
    LessonForm .list MultiSelect { height: 1fr; }
    LessonForm .row MultiSelect { height: 1; width: 1fr; scrollbar-size: 0 0; }
    LessonForm .row { height: 1; }
    LessonForm .row Label { width: 15; }
    LessonForm .row Input { width: 1fr; }
    LessonForm #hint, LessonForm #told { height: auto; }
    LessonForm #hint { margin-bottom: 1; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+g", "take", show=False, priority=True),
        Binding("escape", "give_up", show=False, priority=True),
    ]

    def __init__(self, library: Library, name: str, now: LessonChoices, check: Check, *, again: bool) -> None:
        super().__init__()
        self._library, self._name, self._now, self._check = library, name, now, check
        self._again = again
        self._kept = {state.name: state for state in now.states or () if isinstance(state, State)}
        names = *library.kit.targets, *(now.parameters or ()), *(now.flags or ())
        self._written = {format_names(name): name for name in names}

    @classmethod
    def for_new_lesson(cls, plan: TrainingPlan) -> Self:
        """Make the form for an automaton that the library does not have yet."""

        def check(choices: LessonChoices) -> None:
            choose_targets(plan, make_planned_lesson(plan, choices), choices)

        return cls(plan.library, plan.name, _suggested(plan), check, again=False)

    @classmethod
    def for_lesson(cls, library: Library, lesson: Lesson) -> Self:
        """Make the form for a lesson that continues."""
        automaton = lesson.automaton
        now = LessonChoices(
            states=[state for state in automaton.states[1:] if state.flag is None],
            features=[str(bound) for bound in automaton.features],
            flags=[state.flag for state in automaton.states if state.flag is not None],
            parameters=automaton.parameters,
            watched=lesson.options.watched,
            reaction_s=lesson.options.reaction_s,
        )

        def check(choices: LessonChoices) -> None:
            change = choices.to_design_change(lesson.options)
            change_design(lesson, library, change, {})  # no parameter is new

        return cls(library, automaton.name, now, check, again=True)

    def compose(self) -> ComposeResult:
        """Lay out two lists, and a line for each of the other choices."""
        now = self._now
        yield Static(
            Text.assemble(
                (f"{format_names(str(self._name))}  ", "bold"), (AGAIN if self._again else NEW, "dim")
            ),
            id="hint",
        )
        with Horizontal(id="lists"):
            for title, name in (("States", "states"), ("Features", "features")):
                with Vertical(classes="list"):
                    yield Label(Text(title, "bold underline"))
                    yield MultiSelect(id=name)
        if not self._again:
            yield from _row("Parameters", "parameters", _format_names(now.parameters), "A")
            stand = _format_names(f"{parameter}={target}" for parameter, target in now.targets.items())
            first = _format_names([*self._library.kit.targets][:1])
            yield from _row("…stand for", "targets", stand, f"A={first}")
        yield from _row("Flags", "flags", _format_names(now.flags), "done")
        yield from _row("More states", "more", "", "turn back=turn left: another name for a state above")
        yield from _row(
            "Reaction, s", "reaction", f"{now.reaction_s or 0:g}", "how late your presses come, s: 0.2, or 0"
        )
        with Horizontal(classes="row"):
            yield Label("Silence")
            yield MultiSelect(id="watched")
        yield Static(id="told")

    def on_mount(self) -> None:
        """Fill the lists."""
        states = [_call(state, self._library) for state in self._now.states or ()]
        self._fill(states, [str(feature) for feature in self._now.features or ()])
        self.query_one("#watched", MultiSelect).show_choices(
            [CONSENT], chosen=[CONSENT] if self._now.watched else []
        )
        self.query_one("#states", MultiSelect).focus()

    def _parameters(self) -> list[str]:
        if self._again:
            return list(self._now.parameters or ())
        return self._list_names(self.query_one("#parameters", Input).value)

    def _list_names(self, text: str) -> list[str]:
        """List the names in a line, where they may be written as people read them: "turn left" is rotate_left."""
        return [
            "=".join(self._written.get(name.strip(), "_".join(name.split())) for name in part.split("="))
            for part in _listed(text)
        ]

    def _fill(self, states: Sequence[str], features: Sequence[str]) -> None:
        """Fill the lists with all options, with these selected."""
        library, names = self._library, [*self._parameters(), *self._library.kit.targets]
        behaviors = [*library.kit.behaviors, *(name for name in library.taught if name != self._name)]
        calls = [call for name in behaviors for call in _calls(name, library.parameters(name), names)]
        self._written |= {format_names(call): call for call in calls}
        offers = (
            call
            for name, feature in library.features.items()
            for call in _calls(name, feature.parameters, names)
        )
        self._offer("#states", calls, states)
        self._offer("#features", offers, features)

    def _offer(self, which: str, offered: Iterable[str], chosen: Sequence[str]) -> None:
        every = dict.fromkeys([*chosen, *offered])
        self.query_one(which, MultiSelect).show_choices(every, chosen=chosen)

    def on_input_changed(self, event: Input.Changed) -> None:
        """Update the lists when the parameters change."""
        if event.input.id == "parameters":
            states, features = (
                self.query_one(f"#{name}", MultiSelect).selection for name in ("states", "features")
            )
            self._fill(states, features)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Move on to the next line."""
        self.focus_next()

    def _choices(self) -> LessonChoices:
        text = {each.id: each.value for each in self.query(Input)}
        states = [*self.query_one("#states", MultiSelect).selection, *self._list_names(text["more"])]
        features = self.query_one("#features", MultiSelect).selection
        parameters = self._parameters()
        if not self._again:  # one that was suggested and never used would only have to be bound
            used = {argument for call in (*states, *features) for argument in _arguments(call)}
            parameters = [parameter for parameter in parameters if parameter in used]
        stand = [pair.partition("=") for pair in self._list_names(text.get("targets", ""))]
        return LessonChoices(
            states=_named(states, self._kept, self._library),
            features=features,
            flags=self._list_names(text["flags"]),
            parameters=parameters,
            targets={of: target for of, _, target in stand if self._again or of in parameters},
            watched=bool(self.query_one("#watched", MultiSelect).selection),
            reaction_s=_seconds(text["reaction"]),
        )

    def action_take(self) -> None:
        """Return the choices, if they are valid."""
        try:
            choices = self._choices()
            if not choices.states or not choices.features:
                what = "states" if not choices.states else "features"
                self._tell(f"No {what} yet: choose at least one with space")
                return
            self._check(choices)
        except UnderstudyError as error:
            self._tell(str(error))
            return
        self.dismiss(choices)

    def _tell(self, text: str) -> None:
        self.query_one("#told", Static).update(Text(f"! {format_names(text)}", "bold red"))

    def action_give_up(self) -> None:
        """Cancel."""
        self.dismiss(None)


def _row(label: str, name: str, value: str, placeholder: str) -> ComposeResult:
    with Horizontal(classes="row"):
        yield Label(label)
        yield Input(value, placeholder=placeholder, id=name, compact=True)


def _calls(name: str, parameters: Sequence[str], targets: Sequence[str]) -> list[str]:
    """List a name with its parameters bound in every way: distance_to(A), distance_to(station)."""
    ways = product(targets, repeat=len(parameters))
    return [format_bound_name(name, dict(zip(parameters, way, strict=True))) for way in ways]


def _call(state: str | State, library: Library) -> str:
    """Format a state as in the list: goto(station), or home=goto(station)."""
    if isinstance(state, str):
        return state
    call = START.name if state.behavior is None else library.format_call(state.behavior, state.binding)
    return call if state.name == state.behavior else f"{state.name}={call}"


def _named(calls: Sequence[str], states: dict[str, State], library: Library) -> list[str | State]:
    """Make states from their behaviors; of a behavior that occurs more than once, each name contains its targets."""
    written = {_call(state, library): state for state in states.values()}
    plain = [call.partition("(")[0] for call in calls if "=" not in call]
    named: list[str | State] = []
    for call in calls:
        behavior, _, inside = call.partition("(")
        if call in written:
            named.append(written[call])
        elif "=" not in call and plain.count(behavior) > 1:
            named.append(f"{behavior}_{inside.rstrip(')').replace(', ', '_')}={call}")
        else:
            named.append(call)
    return named


def _suggested(plan: TrainingPlan) -> LessonChoices:
    """Return the choices, with defaults as most lessons have: a parameter, its target, and a flag."""
    choices, kit_targets = plan.choices, plan.library.kit.targets
    parameters = ["A"] if choices.parameters is None else choices.parameters
    stand = {parameter: next(iter(kit_targets)) for parameter in parameters if kit_targets}
    return replace(
        choices,
        parameters=parameters,
        targets={**stand, **choices.targets},
        flags=["done"] if choices.flags is None else choices.flags,
    )


def _arguments(call: str) -> list[str]:
    """Return the targets of a call: station of goto(station)."""
    return _listed(call.partition("(")[2].rstrip(") "))


def _format_names(names: Iterable[str] | None) -> str:
    return ", ".join(map(format_names, names or ()))


def _listed(text: str) -> list[str]:
    return [part.strip() for part in text.split(",") if part.strip()]


def _seconds(text: str) -> float:
    try:
        return float(text or REACTION_S)
    except ValueError:
        raise SettingError(
            where="reaction",
            setting=repr(text),
            problem="is not a number of seconds",
            remedy="write 0.2, or 0",
        ) from None
