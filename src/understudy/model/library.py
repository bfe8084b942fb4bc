"""Libraries: a kit of features, basic behaviors and targets, with the automata that were taught with it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Self, TypeVar

from understudy.errors import DefinitionError, LeftOutOfLibrary, RecursionRefused, UnknownName
from understudy.model.automaton import Automaton
from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import Target, format_bound_name
from understudy.model.drawing import Axes, call_markup, call_plot, format_number_of, format_repr
from understudy.model.features import AnyFeature, Feature, FlagFeature
from understudy.model.lesson import Lesson

KitPart = TypeVar("KitPart", AnyFeature, Behavior, Target)


@dataclass(frozen=True)
class Kit:
    """Features, basic behaviors and targets by name.

    Functions of features and behaviors get columns of readings, float64 [N], a row for each agent, with NaN where a
    reading is absent. They return new columns [N], of the feature's kind (NaN if absent) or finite commands, each row
    of which depends on the same row of the readings only. They keep no memory, change nothing, raise nothing, and may
    be called in any thread at any time, also for readings of an old lesson.

    Parameters
    ----------
    features
        Features by name.
    behaviors
        Basic behaviors by name.
    targets
        Targets by name.
    """

    features: Mapping[str, AnyFeature]
    behaviors: Mapping[str, Behavior]
    targets: Mapping[str, Target]

    @classmethod
    def from_parts(cls, *parts: AnyFeature | Behavior | Target) -> Self:
        """Make a kit from features, basic behaviors and targets.

        Parameters
        ----------
        *parts
            The parts, in the order in which the kit will list those of each kind.

        Returns
        -------
        Kit
            The kit.

        Raises
        ------
        DefinitionError
            If two parts of one kind have the same name, or something else is given.
        """
        features: dict[str, AnyFeature] = {}
        behaviors: dict[str, Behavior] = {}
        targets: dict[str, Target] = {}
        for part in parts:
            if isinstance(part, Behavior):
                _add(behaviors, part, "behaviors")
            elif isinstance(part, Target):
                _add(targets, part, "targets")
            elif isinstance(part, AnyFeature):
                _add(features, part, "features")
            else:
                remedy = "give features, behaviors and targets, one by one"
                raise DefinitionError(what="kit", problem=f"{part!r:.60} is not part of it", remedy=remedy)
        return cls(MappingProxyType(features), MappingProxyType(behaviors), MappingProxyType(targets))

    def __repr__(self) -> str:
        features, behaviors, targets = len(self.features), len(self.behaviors), len(self.targets)
        facts = [format_number_of(behaviors, "behavior"), format_number_of(targets, "target")]
        return format_repr(self, f"of {format_number_of(features, 'feature')}", *facts)

    def __add__(self, other: Kit) -> Kit:
        """Make a kit with the parts of both; refuse a name that both use for the same kind of part."""
        return Kit.from_parts(*self.parts, *other.parts)

    @property
    def parts(self) -> tuple[AnyFeature | Behavior | Target, ...]:
        """All parts of the kit: features, then basic behaviors, then targets."""
        return (*self.features.values(), *self.behaviors.values(), *self.targets.values())


def _add(parts: dict[str, KitPart], part: KitPart, part_kind: str) -> None:
    if part.name in parts:
        raise DefinitionError(
            what="kit", problem=f"two {part_kind} have the name {part.name!r}", remedy="rename one of the two"
        )
    parts[part.name] = part


@dataclass(frozen=True)
class TrainedAutomaton:
    """An automaton of a library, with the lesson from which it was learned.

    Parameters
    ----------
    automaton
        The automaton, with its transition functions.
    lesson
        The lesson. None if the automaton was written by hand.
    """

    automaton: Automaton
    lesson: Lesson | None = None

    def __repr__(self) -> str:
        lesson = (
            "no lesson" if self.lesson is None else format_number_of(len(self.lesson.examples), "example")
        )
        return format_repr(
            self, repr(self.automaton.name), format_number_of(len(self.automaton.states), "state"), lesson
        )

    def plot(self, ax: Axes | None = None) -> Axes:
        """Plot the states as a graph with numbered transitions, and their conditions in words below.

        Thresholds are rounded such that every example of the lesson stays on its side.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw into. None: in a new figure.

        Returns
        -------
        Axes
            The axes; `plot().figure.savefig("NAME.pdf")` writes a vector file.
        """
        return call_plot("automaton_plot:plot_automaton", self, ax)

    def _repr_svg_(self) -> str:
        return call_markup("html_cards:draw_automaton", self)


def check_trained_automaton(value: object) -> None:
    """Refuse anything that is not a TrainedAutomaton, and explain how to make one from a lesson or an automaton."""
    if isinstance(value, TrainedAutomaton):
        return
    what, remedy = f"{value!r:.60}", "give a TrainedAutomaton"
    if isinstance(value, Lesson):
        what, remedy = f"lesson {value.name!r}", "give TrainedAutomaton(learn_automaton(lesson), lesson)"
    if isinstance(value, Automaton):
        what, remedy = f"automaton {value.name!r}", "give TrainedAutomaton(automaton)"
    raise DefinitionError(what=what, problem="it is not a trained automaton", remedy=remedy)


@dataclass(frozen=True)
class Library:
    """A kit and the automata that were taught with it, by name.

    It is immutable: `with_automaton` returns a new library.

    Parameters
    ----------
    kit
        The features, basic behaviors and targets.
    taught
        Trained automata by name.
    left_out
        Why automata of its folder are not among them, by name: they are of another kit.
    """

    kit: Kit
    taught: Mapping[str, TrainedAutomaton] = field(default_factory=lambda: MappingProxyType({}))
    left_out: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    def __repr__(self) -> str:
        automata, behaviors = len(self.taught), len(self.kit.behaviors)
        called = f" {', '.join(self.taught)}" if automata else ""
        facts = [f"{format_number_of(automata, 'automaton', 'automata')}{called}"]
        return format_repr(self, f"with {format_number_of(behaviors, 'basic behavior')}", *facts)

    def _repr_html_(self) -> str:
        return call_markup("html_cards:write_library_html", self)

    @classmethod
    def from_automata(cls, kit: Kit, *automata: Automaton) -> Self:
        """Make a library from a kit and automata that have no lessons.

        Parameters
        ----------
        kit
            The features, basic behaviors and targets.
        *automata
            The automata. Of several with one name the last is kept.

        Returns
        -------
        Library
            The library.

        Raises
        ------
        DefinitionError
            If an automaton has the name of a basic behavior.
        RecursionRefused
            If an automaton would contain itself.
        """
        library = cls(kit)
        for automaton in automata:
            library = library.with_automaton(TrainedAutomaton(automaton))
        return library

    def with_automaton(self, taught: TrainedAutomaton) -> Self:
        """Make a library with an automaton added, or replaced if one of its name exists.

        Parameters
        ----------
        taught
            The automaton with its lesson.

        Returns
        -------
        Library
            The new library; this one stays unchanged.

        Raises
        ------
        DefinitionError
            If it is no TrainedAutomaton, or has the name of a basic behavior.
        RecursionRefused
            If the automaton would contain itself.
        """
        check_trained_automaton(taught)
        name = taught.automaton.name
        if name in self.kit.behaviors:
            raise DefinitionError(
                what=f"automaton {name!r}",
                problem="a basic behavior has this name already",
                remedy="rename the automaton",
            )
        library = replace(self, taught=MappingProxyType({**self.taught, name: taught}))
        library.refuse_recursion(name)
        return library

    @property
    def features(self) -> Mapping[str, AnyFeature]:
        """The features that automata may use, by name: the kit's, and a FlagFeature for each flag raised here."""
        flags = (flag for taught in self.taught.values() for flag in taught.automaton.flags)
        return {**{flag: FlagFeature(flag) for flag in flags}, **self.kit.features}

    def behavior(self, name: str) -> Behavior | Automaton:
        """Return the basic behavior or automaton with the given name.

        Parameters
        ----------
        name
            Name of the behavior.

        Returns
        -------
        Behavior | Automaton
            The basic behavior or automaton.

        Raises
        ------
        UnknownName
            If the library has neither.
        """
        if name in self.taught:
            return self.taught[name].automaton
        if name in self.kit.behaviors:
            return self.kit.behaviors[name]
        raise self._make_unknown("behavior", name, [*self.kit.behaviors, *self.taught])

    def automaton(self, name: str) -> Automaton:
        """Return the automaton with the given name.

        Parameters
        ----------
        name
            Name of the automaton.

        Returns
        -------
        Automaton
            The automaton.

        Raises
        ------
        UnknownName
            If the library has no automaton with this name.
        """
        if name not in self.taught:
            raise self._make_unknown("automaton", name, list(self.taught))
        return self.taught[name].automaton

    def _make_unknown(self, what: str, name: str, names: Sequence[str]) -> UnknownName:
        """Make the error for a name that is none of the library's, with the reason if that is known."""
        where, reason = "the library", self.left_out.get(name)
        if reason is not None:
            return LeftOutOfLibrary(what=what, name=name, where=where, known=names, reason=reason)
        return UnknownName(what=what, name=name, where=where, known=names)

    def parameters(self, name: str) -> tuple[str, ...]:
        """Return the names of the parameters of a basic behavior or automaton.

        Parameters
        ----------
        name
            Name of the behavior.

        Returns
        -------
        tuple[str, ...]
            The names of its parameters.

        Raises
        ------
        UnknownName
            If the library has no behavior with this name.
        """
        return self.behavior(name).parameters

    def format_call(self, name: str, binding: Mapping[str, str]) -> str:
        """Format a behavior with its arguments, such as "goto(station)".

        Parameters
        ----------
        name
            Name of the behavior.
        binding
            Name of a target or parameter by parameter of the behavior.

        Returns
        -------
        str
            The name, and the arguments in the order of the behavior's parameters; in alphabetical order of the
            parameters if the library has no behavior with this name.
        """
        exists = name in self.taught or name in self.kit.behaviors
        return format_bound_name(name, binding, self.parameters(name) if exists else ())

    def find_users(self, name: str) -> tuple[str, ...]:
        """Find the automata that have a state which runs the given behavior.

        Parameters
        ----------
        name
            Name of the basic behavior or automaton.

        Returns
        -------
        tuple[str, ...]
            Names of the automata.
        """
        return tuple(
            key
            for key, taught in self.taught.items()
            if any(state.behavior == name for state in taught.automaton.states)
        )

    def refuse_recursion(self, name: str, above: tuple[str, ...] = ()) -> None:
        """Refuse an automaton that contains itself, directly or through others (paper section 3.1).

        Parameters
        ----------
        name
            Name of the automaton to check.
        above
            Names of the automata around it, outermost first; used by the recursive calls.

        Raises
        ------
        RecursionRefused
            If the automaton contains itself; the error lists the cycle.
        """
        if name in above:
            raise RecursionRefused(cycle=(*above[above.index(name) :], name))
        if name in self.taught:
            for state in self.taught[name].automaton.states:
                if state.behavior is not None:
                    self.refuse_recursion(state.behavior, (*above, name))


def list_dependencies(library: Library, name: str) -> tuple[str, ...]:
    """List an automaton and the automata that it runs, directly or through others."""
    names: dict[str, None] = {}
    waiting = [name]
    while waiting:
        each = waiting.pop()
        if each in library.taught and each not in names:
            names[each] = None
            waiting += [state.behavior or "" for state in library.taught[each].automaton.states]
    return tuple(names)


def list_missing_parts(
    trained: TrainedAutomaton | None, readings: Collection[str], targets: Collection[str]
) -> list[str]:
    """List the readings and targets that an automaton learned from a recording or a table needs, and a body lacks.

    Parameters
    ----------
    trained
        The automaton with its lesson; nothing is missing for one that was taught with a kit.
    readings
        Names of the body's readings.
    targets
        Names of its targets.

    Returns
    -------
    list of str
        The names of what is missing.
    """
    kit = None if trained is None or trained.lesson is None else trained.lesson.kit
    if kit is None:
        return []
    needed = [each.reading for each in kit.features.values() if isinstance(each, Feature) and each.reading]
    return [each for each in needed if each not in readings] + [
        each for each in kit.targets if each not in targets
    ]


def make_lesson_kit(automaton: Automaton, library: Library) -> Kit:
    """Make the kit of what an automaton uses that a recording or a table alone defines.

    Parameters
    ----------
    automaton
        The automaton.
    library
        The library of the recording. A behavior that it lacks commands nothing, as those of tables.

    Returns
    -------
    Kit
        The body's features, the behaviors and the targets that the automaton uses, in the order of the automaton.
        Pairs of readings are not among them, as documents say themselves what they are.
    """
    features = {
        each.feature.name: each.feature
        for each in automaton.features
        if isinstance(each.feature, Feature) and each.feature.pair is None
    }
    behaviors = [each.behavior for each in automaton.states if each.behavior is not None]
    targets = [
        target
        for binding in (
            *(each.binding for each in automaton.features),
            *(each.binding for each in automaton.states),
        )
        for target in binding.values()
        if target not in automaton.parameters
    ]
    return Kit.from_parts(
        *features.values(),
        *(
            library.kit.behaviors.get(name, Behavior(name, Command()))
            for name in dict.fromkeys(behaviors)
            if name not in library.taught
        ),
        *map(Target, dict.fromkeys((*targets, *library.kit.targets))),
    )
