"""Find worlds by name, also functions MODULE:NAME that return a body or an environment instead of a scenario."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from understudy.entry_points import BODIES, WORLDS, load_object
from understudy.model.library import Kit
from understudy.runtime.body import BODY_ATTRIBUTES, Body, Resettable, close_body
from understudy.sim.catalog import (
    call_world_function,
    find_scenario,
    is_function,
    list_bodies,
    refuse_world,
)
from understudy.sim.scenario.files import add_markers
from understudy.sim.scenario.schema import Scenario

REMEDY = (
    "name a function, as MODULE:NAME, that returns a Scenario, a body or an environment of Gymnasium or PettingZoo, "
    "and takes nothing or the seed of the world"
)


@dataclass(frozen=True)
class BodyMaker:
    """A function of the user's own that makes a body. It is called with the seed of a world, and returns its body.

    Parameters
    ----------
    name
        MODULE:NAME of the function, or its name among the entry points `understudy.bodies` and `understudy.worlds`. It
        takes the seed or nothing, and returns a `Body`; or an environment of Gymnasium, or a parallel one of
        PettingZoo, of which a `GymnasiumBody` or `PettingZooBody` is made.
    """

    name: str

    @property
    def __name__(self) -> str:
        """The name, by which an evaluation says where it ran."""
        return self.name

    def __call__(self, seed: int) -> Body:
        """Make the body of a world; SettingError if that fails, or if what is made is no body."""
        function = _load(self.name)
        if not callable(function):
            raise refuse_world(self.name, f"is a {type(function).__name__}", REMEDY)
        seeded = _takes_seed(function, self.name)
        source = call_world_function(function, self.name, *([seed] if seeded else []), remedy=REMEDY)
        body = _make_body(source, seed, self.name)
        if body is source and not seeded and isinstance(body, Resettable):
            body.reset([seed])
        return body

    def find_kit(self) -> Kit:
        """Return the kit of the body, its attribute `kit`; SettingError if it has none."""
        body = self(0)
        kit = getattr(body, "kit", None)
        close_body(body)
        if not isinstance(kit, Kit):
            problem = f"returned a {type(body).__name__} without a kit"
            raise refuse_world(
                self.name, problem, "give the kit: --kit MODULE:NAME, or a body with an attribute kit"
            )
        return kit


def find_world(name: str | Path) -> Scenario | BodyMaker:
    """Find a world by the name of a scenario, or by that of a function.

    A function among the entry points `understudy.bodies` is not called: it may connect to a robot.

    Parameters
    ----------
    name
        What `find_scenario` takes; or a function as MODULE:NAME that returns a body, or an environment of Gymnasium or
        PettingZoo.

    Returns
    -------
    Scenario or BodyMaker
        The scenario, or the function that makes a body.

    Raises
    ------
    UnknownName
        For a text that is none of these.
    FileError
        For a file that is not a scenario.
    SettingError
        For a function that cannot be imported, fails, or returns something else.
    """
    if not (isinstance(name, str) and is_function(name)):
        return find_scenario(name)
    target = _load(name)
    if isinstance(target, Scenario):
        return add_markers(target)
    if not callable(target):
        raise refuse_world(name, f"is a {type(target).__name__}", REMEDY)
    if _takes_seed(target, name) or name in list_bodies():
        return BodyMaker(name)
    world = call_world_function(target, name, remedy=REMEDY)
    if isinstance(world, Scenario):
        return add_markers(world)
    _make_body(world, 0, name)
    return BodyMaker(name)


def _load(name: str) -> Any:
    return load_object(name, BODIES if name in list_bodies() else WORLDS, where="world", remedy=REMEDY)


def _takes_seed(function: Callable[..., Any], name: str) -> bool:
    """Return whether a function needs one argument; SettingError if it needs more."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):  # some that are not written in Python
        return False
    positional = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    needed = [each for each in parameters if each.default is each.empty and each.kind in positional]
    if len(needed) > 1:
        names = ", ".join(each.name for each in needed)
        raise refuse_world(name, f"needs {len(needed)} arguments ({names})", REMEDY)
    return bool(needed)


def _make_body(source: Any, seed: int, name: str) -> Body:
    """Return the body that a function made, or that of the environment that it made."""
    gymnasium: Any = sys.modules.get("gymnasium")  # imported by the module that made an environment
    if gymnasium is not None and isinstance(source, gymnasium.Env):
        from understudy.addons.bridges.environments.gymnasium import GymnasiumBody

        return GymnasiumBody(source, [seed])
    pettingzoo: Any = sys.modules.get("pettingzoo")
    if pettingzoo is not None and isinstance(source, pettingzoo.ParallelEnv):
        from understudy.addons.bridges.environments.pettingzoo import PettingZooBody

        return PettingZooBody(source, [seed])
    missing = [each for each in BODY_ATTRIBUTES if not hasattr(source, each)]
    if len(missing) == len(BODY_ATTRIBUTES):
        raise refuse_world(name, f"returned a {type(source).__name__}", REMEDY)
    if missing:
        remedy = "let it return a body, as the protocol understudy.Body says"
        raise refuse_world(name, f"returned a {type(source).__name__} without {missing[0]!r}", remedy)
    worlds = getattr(source, "worlds", 1)
    if worlds != 1:
        remedy = "let it make one, since the seed is that of one world"
        raise refuse_world(name, f"makes {worlds} worlds", remedy)
    body: Body = source
    return body
