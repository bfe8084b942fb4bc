"""The keys of states: arrows where the direction is obvious, digits, then letters that no command uses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from understudy.errors import UnknownName
from understudy.model.automaton import State
from understudy.model.behaviors import Behavior
from understudy.model.library import Library

DIGITS = "123456789"
LETTERS = "abefgijkmovxz"
"""What the commands of the teaching screen leave free; a test compares the two."""

Arrow: TypeAlias = Literal["up", "down", "left", "right"]
ARROWS: Mapping[str, str] = {"up": "↑", "down": "↓", "left": "←", "right": "→"}


@dataclass(frozen=True, slots=True)
class KeyBindings:
    """The keys of names; `arrows` are second keys for some. `leads` is the inverse."""

    plain: Mapping[str, str]
    arrows: Mapping[str, Arrow]

    @property
    def leads(self) -> dict[str, str]:
        """The name that each key selects."""
        return {key: name for keys in (self.plain, self.arrows) for name, key in keys.items()}

    def label(self, name: str) -> str:
        """Return the keys of a name as two characters: "↑1", " 4"."""
        return ARROWS.get(self.arrows.get(name, ""), " ") + self.plain.get(name, " ")


def bind_state_keys(library: Library, states: Sequence[State]) -> KeyBindings:
    """Assign keys to the states of an automaton; 0 is its start state."""
    start, *others = states
    plain = {start.name: "0", **_counted([state.name for state in others])}
    behaviors = {state.name: _basic(library, state.behavior) for state in others}
    return KeyBindings(plain, _arrows(behaviors))


def bind_drive_keys(behaviors: Sequence[Behavior]) -> KeyBindings:
    """Assign keys to the basic behaviors with which the robot is driven."""
    return KeyBindings(
        _counted([behavior.name for behavior in behaviors]),
        _arrows({behavior.name: behavior for behavior in behaviors}),
    )


def _counted(names: Sequence[str]) -> dict[str, str]:
    return dict(zip(names, DIGITS + LETTERS, strict=False))


def _basic(library: Library, name: str | None) -> Behavior | None:
    try:
        behavior = library.behavior(name) if name is not None else None
    except UnknownName:
        return None
    return behavior if isinstance(behavior, Behavior) else None


def _arrows(behaviors: Mapping[str, Behavior | None]) -> dict[str, Arrow]:
    """Assign an arrow to the first name that drives or turns in its direction and does nothing else."""
    arrows: dict[str, Arrow] = {}
    for name, behavior in behaviors.items():
        arrow = _arrow(behavior)
        if arrow and arrow not in arrows.values():
            arrows[name] = arrow
    return arrows


def _arrow(behavior: Behavior | None) -> Arrow | None:
    if behavior is None or len(behavior.command) != 1:
        return None
    ((channel, amount),) = behavior.command.items()
    if channel == "drive" and amount:
        return "up" if amount > 0 else "down"
    if channel == "turn" and amount:
        return "left" if amount > 0 else "right"
    return None
