"""Report errors in scenarios, each with its key and a remedy, and define limits of numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple, NoReturn

from understudy.errors import SettingError, join_names, suggest_known_name
from understudy.sim.scenario.schema import Scenario


class ScenarioErrors:
    """A scenario under check, and the errors for its keys."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario

    def fail(self, key: str, problem: str, remedy: str) -> NoReturn:
        """Raise SettingError for a key of the scenario."""
        where = f"scenario {str(self.scenario.name)!r}"
        raise SettingError(where=where, setting=key, problem=problem, remedy=remedy)

    def check_known(self, key: str, name: str, names: Iterable[str], *, what: str) -> None:
        """Raise SettingError if a name is not among `names`."""
        names = list(dict.fromkeys(names))
        if name not in names:
            self.fail(key, f"is {name!r}, and there is no such {what}", suggest_name(name, names, what=what))


def suggest_name(name: str, names: Iterable[str], *, what: str) -> str:
    """Return a remedy for an unknown name: a similar known name, and all known names."""
    names = list(names)
    return (
        f"{suggest_known_name(name, names)}known are {join_names(map(repr, names))}"
        if names
        else f"declare a {what} of this name first"
    )


MOST_THINGS = 10_000_000
MOST_SPARE = 10_000
"""The largest number of spare objects; each takes memory and time in every world."""


class Limit(NamedTuple):
    """A condition that a number must meet, and its description in words."""

    holds: Callable[[float], bool]
    words: str


POSITIVE = Limit(lambda number: number > 0, "a number above 0")
NOT_NEGATIVE = Limit(lambda number: number >= 0, "0 or more")
TICK = Limit(lambda number: number >= 0.0001, "0.0001 or more")
AT_LEAST_1 = Limit(lambda number: number >= 1, "1 or more")
CHANCE = Limit(lambda number: 0 <= number <= 1, "a probability from 0 to 1")
VIEW = Limit(lambda number: 0 < number < 180, "more than 0 and less than 180 degrees")
THINGS = Limit(
    lambda number: 0 <= number <= MOST_THINGS, f"a number from 0 to {MOST_THINGS:,}".replace(",", " ")
)
SPARE = Limit(
    lambda number: 0 <= number <= MOST_SPARE, f"a number from 0 to {MOST_SPARE:,}".replace(",", " ")
)
GENERATOR = Limit(lambda number: number in {1, 2}, "1 or 2")
PIXELS = Limit(lambda number: 1 <= number <= 100_000, "1 to 100 000 pixels")
