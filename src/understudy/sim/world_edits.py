"""Changes of a world by hand: robots are placed, objects and obstacles are added, moved and removed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from math import isfinite, nan, tau
from typing import Any

import numpy as np

from understudy.errors import SettingError, UnknownName, join_names
from understudy.sim.kernels.dtypes import DISC
from understudy.sim.layout.clearance import find_overlap
from understudy.sim.params import ScenarioNames
from understudy.sim.scenario.schema import MOUSE, Scenario
from understudy.sim.state import WorldParams, WorldState


class EditableWorld(ABC):
    """The part of a world that is changed by hand. A refused change leaves the world as it was."""

    scenario: Scenario
    state: WorldState
    rules: WorldParams
    names: ScenarioNames
    worlds: int
    robots: int
    agents: int

    @abstractmethod
    def _begin(self, state: WorldState) -> None:
        """Continue from a state whose obstacles changed."""

    def place(self, agent: int, x: float, y: float, heading: float) -> None:
        """Move a robot to a free place, standing still; it lets go of a box that it holds, and keeps its food.

        Parameters
        ----------
        agent
            The row of the robot, from 0 to B*N - 1.
        x
            The place, m from the left wall. SettingError if it is outside the arena or overlaps something solid.
        y
            The place, m from the bottom wall.
        heading
            The direction to face, rad counter-clockwise from the x axis.
        """
        robot = self.state.robots[self._index("agent", agent, self.agents)]
        kind, world = self.rules.types[robot["type"]], agent // self.robots
        self._finite(f"place of robot {agent}", x, y, heading)
        self._free(
            f"place of robot {agent}", x, y, kind["radius"], world=world,
            robot=int(robot["id"]), collides=bool(kind["collides"]),
        )  # fmt: skip
        if robot["holding"]:
            self.state.objects["hands"][world, robot["holding"] - 1] -= 1
        robot["x"], robot["y"], robot["heading"] = x, y, float(heading) % tau % tau
        for name in ("speed", "spin", "loading", "unloading", "blocked", "holding"):
            robot[name] = 0

    def move_object(self, slot: int, x: float, y: float, *, world: int = 0) -> None:
        """Move an object to a free place; robots that hold it let go.

        Parameters
        ----------
        slot
            The slot of the object, one of `view().objects.slot`. SettingError if no object is there.
        x
            The place, m from the left wall. SettingError if the place is not free.
        y
            The place, m from the bottom wall.
        world
            The index of the world, from 0.
        """
        thing = self._object(slot, world)
        self._free_for(f"place of object {slot}", self.rules.class_of[slot], x, y, world=world, slot=slot)
        self._let_go(slot, world)
        thing["x"], thing["y"] = x, y

    def add_object(self, name: str, x: float, y: float, *, amount: int = 0, world: int = 0) -> int:
        """Add an object of a class at a free place.

        Parameters
        ----------
        name
            The class of objects in the scenario. UnknownName if it does not exist.
        x
            The place, m from the left wall. SettingError if the place is not free.
        y
            The place, m from the bottom wall.
        amount
            Units of food in it; 0 for objects that are not food.
        world
            The index of the world, from 0.

        Returns
        -------
        int
            The slot of the object, by which other methods refer to it.

        Raises
        ------
        SettingError
            If the place is not free, the amount is not valid, or all `spare_objects` of the scenario are in use.
        """
        kind = self._class(name)
        self._index("world", world, self.worlds)
        self._free_for(f"place of {name!r}", self.names.classes.index(name), x, y, world=world)
        most = 2**31 - 1 if kind["food"] else 0
        if not is_whole(amount, most):
            remedy = "give a whole number from 0 up" if kind["food"] else "leave it out: it is not food"
            raise self._wrong(f"amount of {name!r}", f"is {amount}", remedy)
        things = self.state.objects[world, kind["first"] : kind["end"]]
        free = np.flatnonzero((things["present"] == 0) & (things["due"] < 0))
        if not len(free):
            raise self._wrong(
                f"objects {name!r}", f"are {len(things)} already", "remove one, or give more spare_objects"
            )
        slot = int(kind["first"]) + int(free[0])
        gathered = self.state.objects["gathered"][world, slot]  # a box that was there once still counts
        self.state.objects[world, slot] = np.zeros((), self.state.objects.dtype)
        thing = self.state.objects[world, slot]
        thing["x"], thing["y"], thing["present"], thing["gathered"] = x, y, 1, gathered
        thing["amount"] = thing["at_first"] = amount
        thing["due"] = thing["captured"] = -1
        return slot

    def remove_object(self, slot: int, *, world: int = 0) -> None:
        """Remove an object for good; robots that hold it let go.

        Parameters
        ----------
        slot
            The slot of the object, one of `view().objects.slot`. SettingError if no object is there.
        world
            The index of the world, from 0.
        """
        thing = self._object(slot, world)
        self._let_go(slot, world)
        thing["present"], thing["due"], thing["amount"] = 0, -1, 0

    def _let_go(self, slot: int, world: int) -> None:
        """Make all robots of a world release an object."""
        robots = self.state.robots[world * self.robots : (world + 1) * self.robots]
        robots["holding"][robots["holding"] == slot + 1] = 0
        self.state.objects["hands"][world, slot] = 0

    def add_obstacle(self, x: float, y: float, radius: float, *, world: int = 0) -> None:
        """Add a round obstacle to a world; it may overlap walls and other obstacles.

        Parameters
        ----------
        x
            The place, m from the left wall. SettingError if the obstacle overlaps a robot or a solid object.
        y
            The place, m from the bottom wall.
        radius
            The radius, m.
        world
            The index of the world, from 0.
        """
        self._index("world", world, self.worlds)
        self._finite("place of an obstacle", x, y, radius)
        if not radius > 0:
            raise self._wrong("radius of an obstacle", f"is {radius}", "give a number above 0")
        self._free("place of an obstacle", x, y, radius, world=world, stays=True)
        discs = np.zeros((self.worlds, self.state.discs.shape[1] + 1), DISC)
        discs[:, :-1] = self.state.discs
        discs["color"][:, -1] = -1
        discs[world, -1] = (x, y, radius, 2 * radius, -1)
        self._begin(self.state._replace(discs=discs))

    def move_obstacle(self, index: int, x: float, y: float, *, world: int = 0) -> None:
        """Move a round obstacle; it may overlap walls and other obstacles.

        Parameters
        ----------
        index
            The position of the obstacle in `view().discs`.
        x
            The place, m from the left wall. SettingError if the obstacle overlaps a robot or a solid object.
        y
            The place, m from the bottom wall.
        world
            The index of the world, from 0.
        """
        disc = self._obstacle(index, world)
        self._finite("place of an obstacle", x, y, 0.0)
        self._free("place of an obstacle", x, y, float(disc["radius"]), world=world, stays=True)
        disc["x"], disc["y"] = x, y
        self._begin(self.state)

    def remove_obstacle(self, index: int, *, world: int = 0) -> None:
        """Remove a round obstacle.

        Parameters
        ----------
        index
            The position of the obstacle in `view().discs`; the positions after it decrease by 1.
        world
            The index of the world, from 0.
        """
        self._obstacle(index, world)["radius"] = 0
        self._begin(self.state)

    def place_pointer(self, x: float | None, y: float | None = None, *, world: int = 0) -> None:
        """Set the position of the target `mouse`, which robots can follow, or remove it.

        Parameters
        ----------
        x
            The place, m from the left wall; None, with `y` None, removes the pointer.
        y
            The place, m from the bottom wall.
        world
            The index of the world, from 0.
        """
        self._index("world", world, self.worlds)
        thing = self.state.objects[world, self._class(MOUSE)["first"]]
        if x is None and y is None:
            thing["present"] = 0
            return
        x, y = nan if x is None else x, nan if y is None else y  # one of the two alone is no place
        self._finite("pointer", x, y, 0.0)
        thing["x"], thing["y"], thing["present"] = x, y, 1

    def freeze(self, agent: int) -> None:
        """Make a robot fail: from now on all its readings are absent (NaN), and it does not move.

        Parameters
        ----------
        agent
            The row of the robot, from 0 to B*N - 1.
        """
        self.state.robots["frozen"][self._index("agent", agent, self.agents)] = 1

    # What is refused.

    @property
    def _where(self) -> str:
        return f"world {self.scenario.name!r}"

    def _wrong(self, setting: str, problem: str, remedy: str) -> SettingError:
        return SettingError(where=self._where, setting=setting, problem=problem, remedy=remedy)

    def _class(self, name: str) -> Any:
        if name not in self.names.classes:
            raise UnknownName(what="class of objects", name=name, where=self._where, known=self.names.classes)
        return self.rules.classes[self.names.classes.index(name)]

    def _index(self, what: str, index: int, count: int) -> int:
        if not is_whole(index, count - 1):
            raise self._wrong(what, f"is {index!r}", f"give one from 0 to {count - 1}")
        return int(index)

    def _object(self, slot: int, world: int) -> Any:
        """Return the object in a slot; raise SettingError if no object is there."""
        things = self.state.objects[self._index("world", world, self.worlds)]
        if not things[self._index("slot", slot, len(things))]["present"]:
            there = join_names(map(str, np.flatnonzero(things["present"])))
            raise self._wrong(
                "slot", f"is {slot}, but there is no object with this index", f"give one of {there}"
            )
        return things[slot]

    def _obstacle(self, index: int, world: int) -> Any:
        """Return the round obstacle at a position among those that exist; raise SettingError if there is none."""
        discs = self.state.discs[self._index("world", world, self.worlds)]
        there = np.flatnonzero(discs["radius"] > 0)
        if not len(there):
            raise self._wrong("obstacle", f"is {index}, but there is no such index", "add one first")
        return discs[there[self._index("obstacle", index, len(there))]]

    def _finite(self, what: str, x: float, y: float, third: float) -> None:
        width, height = self.rules.width, self.rules.height
        numbers = all(isinstance(each, int | float | np.floating | np.integer) for each in (x, y, third))
        if not (numbers and 0 <= x <= width and 0 <= y <= height and isfinite(third)):
            problem = f"is ({x}, {y}{f', {third}' if third else ''})"
            where = f"x in [0, {width}] and y in [0, {height}]"
            raise self._wrong(what, problem, f"give {where}, all finite")

    def _free_for(self, what: str, index: int, x: float, y: float, *, world: int, slot: int = -1) -> None:
        """Raise SettingError if an object of a class cannot be at (x, y), in m."""
        self._finite(what, x, y, 0.0)
        kind = self.rules.classes[index]
        if kind["solid"]:
            self._free(what, x, y, kind["radius"], world=world, slot=slot)

    def _free(self, what: str, x: float, y: float, radius: float, *, world: int, **but: Any) -> None:
        """Raise SettingError if a solid disc at (x, y), m, would overlap something else."""
        overlap = find_overlap(self.state, self.rules, self.names, world, x, y, radius, **but)
        if overlap is not None:
            raise self._wrong(what, f"is ({x}, {y}), which overlaps {overlap}", "give a free place")


def is_whole(value: object, most: int) -> bool:
    """Return whether a value is a whole number from 0 to `most`."""
    return isinstance(value, int | np.integer) and 0 <= int(value) <= most
