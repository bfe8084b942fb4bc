"""How what is wrong with a scenario is said: one error that names the key, and what would be right."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from typing import NoReturn

from understudy.errors import SettingError, join_names
from understudy.sim.scenario.schema import Scenario


class ScenarioErrors:
    """A scenario, and the error for what is wrong at a key of it."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario

    def wrong(self, key: str, problem: str, remedy: str) -> NoReturn:
        """Raise the error."""
        where = f"scenario {str(self.scenario.name)!r}"
        raise SettingError(where=where, setting=key, problem=problem, remedy=remedy)

    def known(self, key: str, name: str, names: Iterable[str], *, what: str) -> None:
        """Error where a name is none of those there are."""
        names = list(dict.fromkeys(names))
        if name not in names:
            self.wrong(key, f"is {name!r}, and there is no such {what}", suggest_name(name, names, what=what))


def suggest_name(name: str, names: Iterable[str], *, what: str) -> str:
    """What to give instead of an unknown name."""
    names = list(names)
    close = get_close_matches(name, names, n=1)
    meant = f"did you mean {close[0]!r}? " if close else ""
    return (
        f"{meant}known are {join_names(map(repr, names))}"
        if names
        else f"declare a {what} of this name first"
    )
