"""Kits and candidates for drives: what a recording offers, and the behaviors that may explain it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product

from understudy.addons.recordings.candidates import BehaviorCandidate, Candidate
from understudy.errors import UnknownName
from understudy.model.automaton import Automaton
from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import Binding, Target
from understudy.model.features import BoundFeature, Feature, TimeInState
from understudy.model.library import Kit, Library
from understudy.records.record import Record
from understudy.runtime.link import GroundBehavior

PARAMETER = "A"
"""The name of the target parameter of features that are readings of a target."""


def make_drive_kit(drive: Record, behaviors: Mapping[str, Mapping[str, float]]) -> Kit:
    """Make a kit of what a drive has: a feature for each reading, its targets, and behaviors given as commands.

    Parameters
    ----------
    drive
        The drive.
    behaviors
        Command by channel of each behavior.

    Returns
    -------
    Kit
        The kit.
    """
    features = (
        Feature(
            each.name,
            each.kind,
            each.name,
            of=PARAMETER if each.of_targets else None,
            unit=each.unit,
            doc=each.doc,
        )
        for each in drive.readings
    )
    return Kit.from_parts(
        *features,
        TimeInState(),
        *(Behavior(name, Command(**command)) for name, command in behaviors.items()),
        *map(Target, drive.targets),
    )


def list_drive_features(library: Library, drive: Record) -> tuple[BoundFeature, ...]:
    """List the features of a kit that are readings of a drive, with each target of which it has the reading."""
    bound_features = []
    for feature in library.kit.features.values():
        if isinstance(feature, Feature) and feature.reading is not None:
            for target in drive.targets if feature.of else (None,):
                if (feature.reading, target) in drive.values:
                    binding = Binding({feature.of: target} if feature.of and target else {})
                    bound_features.append(BoundFeature(feature, binding))
    return tuple(bound_features)


def make_candidates(
    library: Library, drive: Record, behaviors: Sequence[str] | None = None
) -> tuple[Candidate, ...]:
    """Make candidates of basic behaviors and automata, one for each choice of their targets in a drive.

    Parameters
    ----------
    library
        The behaviors that names refer to.
    drive
        The drive, whose targets parameters are bound to.
    behaviors
        Names such as "forward", or with targets, "goto(ball)". None: all basic behaviors of the kit that command
        channels of the drive.

    Returns
    -------
    tuple
        The candidates, in the order of the names.

    Raises
    ------
    UnknownName
        If a behavior or a target does not exist.
    """
    return tuple(
        candidate
        for name in (list(library.kit.behaviors) if behaviors is None else behaviors)
        for candidate in _ground(library, drive, name, is_named=behaviors is not None)
    )


def _ground(library: Library, drive: Record, call: str, *, is_named: bool) -> Iterator[Candidate]:
    name, _, rest = call.partition("(")
    name = name.strip()
    behavior = library.behavior(name)
    arguments = [each.strip() for each in rest.rstrip().removesuffix(")").split(",") if each.strip()]
    for target in arguments:
        if target not in drive.targets:
            raise UnknownName(what="target", name=target, where="the recording", known=drive.targets)
    channels = {each.name for each in drive.channels}
    if isinstance(behavior, Behavior) and not is_named and not channels >= set(behavior.command):
        return
    choices = [arguments] if arguments else product(drive.targets, repeat=len(behavior.parameters))
    for targets in choices:
        binding = Binding(dict(zip(behavior.parameters, targets, strict=False)))
        if isinstance(behavior, Automaton):
            from understudy.addons.recordings.automaton_candidate import AutomatonCandidate

            yield AutomatonCandidate(library, name, binding)
        else:
            yield BehaviorCandidate(GroundBehavior(behavior, binding))


def remove_functions(library: Library) -> Library:
    """Return a library whose basic behaviors have no functions, for lessons over readings that nothing moves."""
    behaviors = {
        name: replace(each, function=None, command=Command()) if each.function is not None else each
        for name, each in library.kit.behaviors.items()
    }
    return replace(library, kit=replace(library.kit, behaviors=behaviors))
