"""The hundred worlds side by side: what the page draws of them, and the messages about them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from understudy.addons.checks.falsification.new_worlds import Mistake
from understudy.errors import SessionError
from understudy.sim.view import WorldView
from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.world_grid import GridResult, GridWorld, begin_search, visit
from understudy.ui.web.background import SlowAction
from understudy.ui.web.messages.base import Data
from understudy.ui.web.messages.review import ReadWorldGrid, RunWorldGrid, VisitGridWorld, VisitUnseenWorld
from understudy.ui.web.session_host import SessionHost

CM = 2
"""The number of digits of places, m."""


class GridThingData(Data, frozen=True, kw_only=True):
    """A thing in a world at the start: an object of a class of the scene, by its index, and how large it is there."""

    kind: int
    x: float
    y: float
    amount: int


class GridWorldData(Data, frozen=True, kw_only=True):
    """One of the worlds: where things stand at the start, and where robots went until its run ended."""

    seed: int
    works: bool
    was_shown: bool
    """Whether it was on the page, so that it is new no more."""
    end_s: float
    paths: list[list[float]]
    """For each robot x, y, x, y and so on at the first of the times, m; the trained one comes first."""
    things: list[GridThingData]
    lines: list[list[float]]
    """The walls and the edges of obstacles: x, y of one end and of the other, m."""
    discs: list[list[float]]
    """The round obstacles: x, y and radius, m."""


class WorldGridData(Data, frozen=True, kw_only=True):
    """The runs of what is in training in all worlds."""

    name: str
    width: float
    height: float
    robot_radius: float
    times: list[float]
    """When robots were at the places of paths, s."""
    works: int
    """The number of worlds in which it works."""
    success: str
    """What success means, in words."""
    worlds: list[GridWorldData]


class WorldGridReply(Data, frozen=True, kw_only=True):
    """The newest runs."""

    grid: WorldGridData


def run_world_grid(host: SessionHost, _: RunWorldGrid) -> SlowAction:
    """Run what is in training in a hundred new worlds; the world here waits, as nobody looks at it meanwhile."""
    host.beside.check_runs()
    trainer = host.active_trainer
    run, results = trainer.world_grid.begin(), list[GridResult]()
    if not trainer.session.paused:
        trainer.pause()
    return SlowAction(
        StatusMessage(f"{trainer.name} runs in new worlds…"),
        lambda: results.append(run()),
        lambda: trainer.world_grid.finish(results[0]),
    )


def read_world_grid(host: SessionHost, _: ReadWorldGrid) -> WorldGridReply:
    """Describe the newest runs for the page."""
    result = host.active_trainer.world_grid.result
    if result is None:
        raise SessionError("nothing was run in these worlds yet: show them first")
    view = result.worlds[0].view
    return WorldGridReply(
        grid=WorldGridData(
            name=result.name,
            width=view.width,
            height=view.height,
            robot_radius=float(view.robots.radius.max()),
            times=[round(each, CM) for each in result.times],
            works=result.works,
            success=host.active_trainer.score.goal,
            worlds=[_describe_world(each) for each in result.worlds],
        )
    )


def _describe_world(world: GridWorld) -> GridWorldData:
    places: Any = np.round(world.path, CM)
    view = world.view
    return GridWorldData(
        seed=world.seed,
        works=world.works,
        was_shown=world.was_shown,
        end_s=round(world.end_s, CM),
        paths=[places[:, robot].ravel().tolist() for robot in range(places.shape[1])],
        things=_list_things(view),
        lines=np.round(np.concatenate([view.walls, view.edges]), CM).tolist(),
        discs=np.round(np.stack([view.discs.x, view.discs.y, view.discs.radius], axis=1), CM).tolist(),
    )


def _list_things(view: WorldView) -> list[GridThingData]:
    things = view.objects
    rows = zip(
        things.kind.tolist(), things.x.tolist(), things.y.tolist(), things.at_first.tolist(), strict=True
    )
    return [
        GridThingData(kind=int(kind), x=round(x, CM), y=round(y, CM), amount=int(amount))
        for kind, x, y, amount in rows
    ]


def visit_grid_world(host: SessionHost, message: VisitGridWorld) -> SlowAction:
    """Go to where it went wrong in one of these worlds."""
    find = host.active_trainer.world_grid.begin_visit(message.seed)
    return make_visit(host, message.seed, find)


def visit_unseen_world(host: SessionHost, message: VisitUnseenWorld) -> SlowAction:
    """Go to where what is in training goes wrong in one of the worlds in which it was evaluated."""
    if host.evaluation is None:
        raise SessionError("nothing was tested in other worlds yet")
    find = begin_search(host.active_trainer, message.seed, host.evaluation.binding)
    return make_visit(host, message.seed, find)


def make_visit(host: SessionHost, seed: int, find: Callable[[], Mistake]) -> SlowAction:
    """Make the action that finds when it goes wrong in a world, and goes there."""
    trainer, mistakes = host.active_trainer, list[Mistake]()

    def finish() -> StatusMessage:
        if host.trainer is not trainer:
            return StatusMessage(f"{trainer.name} is not in training any more")
        status = visit(trainer, mistakes[0])
        host.clear_rewind()
        return status

    return SlowAction(StatusMessage(f"Looking at world {seed}…"), lambda: mistakes.append(find()), finish)
