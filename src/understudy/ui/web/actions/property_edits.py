"""Handle messages about the properties in the library's file: write, delete, test, and what they can name."""

from __future__ import annotations

import os

from understudy.errors import FileError, SessionError, UnderstudyError, UnknownName
from understudy.judging.evaluate import find_flags
from understudy.judging.properties.condition_examples import ConditionExample, list_condition_examples
from understudy.judging.properties.edit_property_file import write_property
from understudy.judging.properties.library_properties import FittingLibraries, check_in_world
from understudy.judging.properties.property_file import FILE, locate_errors, locate_world, parse_property
from understudy.model.library import Library
from understudy.sim.catalog import list_scenarios
from understudy.sim.scenario.files import SUFFIX
from understudy.sim.team.libraries import find_behavior_sort
from understudy.sim.world import World
from understudy.ui.controller.failing_worlds import make_draft
from understudy.ui.controller.status import StatusMessage
from understudy.ui.web.messages.base import Data
from understudy.ui.web.messages.review import (
    DeleteProperty,
    ListPropertyChoices,
    PropertyFieldsData,
    SaveProperty,
    TestProperties,
)
from understudy.ui.web.property_list import find_field, make_property_table
from understudy.ui.web.session_host import SessionHost
from understudy.ui.web.views.scene import BehaviorParametersData

RESERVED = ("understudy", "version")
"""Keys of the file itself, which cannot be names of properties."""


class PropertyMistakeReply(Data, frozen=True, kw_only=True):
    """A mistake in the form of a property, which was not written."""

    field: str
    """The field of the form; empty if it is about the file."""
    mistake: str


class PropertyChoicesReply(Data, frozen=True, kw_only=True):
    """The names that a property in a world can use; all but the worlds are empty if the world cannot be opened."""

    worlds: list[str]
    behaviors: list[BehaviorParametersData]
    bindable: list[str]
    """The targets for the parameters of the behavior."""
    conditions: tuple[ConditionExample, ...]
    """Conditions to begin with."""


def handle_save_property(host: SessionHost, message: SaveProperty) -> PropertyMistakeReply | StatusMessage:
    """Check a property as the file is checked, write it to the file, and begin to test it."""
    _refuse_unsimulated(host)
    host.properties.read()
    path, name = host.properties.path, message.name
    try:
        if not message.changes and (name in host.properties.tables or name in RESERVED):
            raise FileError(
                path=path, place=name, problem="there is a table of this name", remedy="give another name"
            )
        table = make_property_table(path, name, message.fields)
        subject = parse_property(path, name, table)
        with locate_errors(path, name, "world"):
            _refuse_unknown_world(host, name, message.fields)
        draft = make_draft(host.trainer)
        check_in_world(path, subject, lambda world: host.library_source.open_world(world, draft))
        write_property(path, name, table)
    except FileError as error:
        field, mistake = find_field(name, error)
        return PropertyMistakeReply(field=field, mistake=mistake)
    host.properties.read()
    host.properties.begin_tests(name, host.library_source, host.trainer)
    return StatusMessage(f"{name} is in {FILE} of the library, and is being tested", "recorded")


def _refuse_unknown_world(host: SessionHost, name: str, fields: PropertyFieldsData) -> None:
    """Refuse a world that is neither offered nor that of the property now: a page may not read any file."""
    table = host.properties.tables.get(name)
    now = table.get("world") if isinstance(table, dict) else None
    worlds = _list_worlds(host)
    if fields.world not in (now, *worlds):
        raise UnknownName(what="world", name=fields.world, where="the studio", known=worlds)


def _refuse_unsimulated(host: SessionHost) -> None:
    if not isinstance(host.world, World):
        raise SessionError("properties are tested in simulated worlds: open the studio with one")


def _list_worlds(host: SessionHost) -> list[str]:
    """List the scenarios by name, and the saved ones by their files, relative to the library's folder."""
    saved = sorted(host.places.scenarios.glob(f"*{SUFFIX}"))
    return [*list_scenarios(), *(os.path.relpath(each, host.folder).replace(os.sep, "/") for each in saved)]


def handle_delete_property(host: SessionHost, message: DeleteProperty) -> StatusMessage:
    """Remove a property from the file."""
    _refuse_unsimulated(host)
    host.properties.read()
    path, name = host.properties.path, message.name
    if name not in host.properties.tables:
        raise UnknownName(what="property", name=name, where=str(path), known=list(host.properties.tables))
    write_property(path, name, None)
    host.properties.read()
    return StatusMessage(f"{name} is deleted from {FILE}")


def handle_test_properties(host: SessionHost, message: TestProperties) -> StatusMessage | None:
    """Read the file again, and begin to test one property or all."""
    _refuse_unsimulated(host)
    host.properties.read()
    if host.properties.begin_tests(message.name, host.library_source, host.trainer) == 0:
        return StatusMessage(f"There is no property to test in {host.properties.path.name}")
    return None


def handle_list_property_choices(host: SessionHost, message: ListPropertyChoices) -> PropertyChoicesReply:
    """List the names that a property in a world can use."""
    _refuse_unsimulated(host)
    worlds = _list_worlds(host)
    behaviors = list[BehaviorParametersData]()
    bindable, conditions = list[str](), tuple[ConditionExample, ...]()
    used = {table.get("world") for table in host.properties.tables.values() if isinstance(table, dict)}
    if message.world in (*worlds, *used):
        try:
            world = locate_world(host.properties.path, message.world)
            where = host.library_source.open_world(world, make_draft(host.trainer))
            behaviors = _list_behaviors(where)
            library, flags = _find_behavior(where, message.behavior)
            bindable = list(library.kit.targets)
            sample = World(where.scenario, [0])
            conditions = list_condition_examples(sample, library, flags, message.behavior.split("/")[-1])
        except UnderstudyError:
            pass  # saving says why
    return PropertyChoicesReply(worlds=worlds, behaviors=behaviors, bindable=bindable, conditions=conditions)


def _list_behaviors(where: FittingLibraries) -> list[BehaviorParametersData]:
    """List the automata of all libraries; SORT/NAME where several libraries have one of this name."""
    libraries = {id(each): (sort, each) for sort, each in where.libraries.items()}
    names = [name for _, each in libraries.values() for name in each.taught]
    return [
        BehaviorParametersData.of(
            each.taught[name].automaton, name=name if names.count(name) == 1 else f"{sort}/{name}"
        )
        for sort, each in libraries.values()
        for name in each.taught
    ]


def _find_behavior(where: FittingLibraries, behavior: str) -> tuple[Library, list[str]]:
    """Return the library that a behavior is in, and the flags that it can raise."""
    sort = find_behavior_sort(where.libraries, behavior or None)
    library = where.libraries[sort]
    return library, sorted(find_flags(library, behavior.removeprefix(f"{sort}/")))
