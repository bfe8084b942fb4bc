"""Export an automaton of the library to a target, as a zip that the page downloads; nothing is changed or kept."""

from __future__ import annotations

from asyncio import wrap_future
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import quote
from zipfile import ZIP_DEFLATED, ZipFile

from understudy.addons.export.body_interface import (
    BodyInterface,
    RobotInterface,
    describe_body,
    describe_kit,
    describe_robot,
)
from understudy.addons.export.export_automaton import ExportResult, export_automaton
from understudy.addons.export.identifiers import make_identifier
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.twin import DigitalTwin
from understudy.errors import SessionError, SettingError
from understudy.model.library import Library
from understudy.ui.web.file_requests import FileReply, FileRequest
from understudy.ui.web.session_host import SessionHost

PATH = "/export.zip"
MOST_ROBOT_FILE = 256 * 1024
"""The greatest size of an uploaded robot file, in bytes."""
UPLOADED = "the robot's file"
MESSAGE_HEADER = "X-Understudy-Message"
"""The header with a sentence about the export, percent-encoded."""


@dataclass(frozen=True, slots=True)
class ExportOrder:
    """What a page asks for: an automaton, its target and binding, and the content of a robot's file, if it sent one."""

    name: str
    to: str
    binding: Mapping[str, str]
    single_precision: bool
    robot_file: str | None


async def export_as_zip(host: SessionHost, request: FileRequest) -> FileReply:
    """Export an automaton as a request orders it.

    The query has `name`, `to`, `bind` (PARAMETER=TARGET, several times) and `single`; the content is a robot's file.
    """
    order = await _read_order(request)
    library = host.library_view.library
    host.library_view.find_automaton(order.name)
    body = _describe_body(host, library, order)
    content, sentence = await wrap_future(host.beside.at_once.submit(zip_export, library, order, body))
    headers = {
        "Content-Disposition": f'attachment; filename="{_find_stem(order)}.zip"',
        MESSAGE_HEADER: quote(sentence),
    }
    return FileReply(content, "application/zip", headers=headers)


async def _read_order(request: FileRequest) -> ExportOrder:
    binding = dict(value.partition("=")[::2] for name, value in request.query if name == "bind")
    problem = f"{UPLOADED} is larger than {MOST_ROBOT_FILE // 1024} kB: give that of one robot"
    content = await request.read(MOST_ROBOT_FILE, problem, status=400)
    try:
        robot_file = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise SessionError(f"{UPLOADED} is not text in UTF-8: give a TOML file") from None
    single = request.find("single") == "1"
    return ExportOrder(request.find("name"), request.find("to"), binding, single, robot_file or None)


def _describe_body(host: SessionHost, library: Library, order: ExportOrder) -> BodyInterface | RobotInterface:
    """Describe the body to export for: the robot of the uploaded file, the studio's real robot, or its world."""
    world = host.world
    if any(each.order is not None for each in library.kit.behaviors.values()):
        return describe_kit(library, tick_s=world.tick_s)
    if order.robot_file is not None:
        file = parse_robot(order.robot_file, UPLOADED)
        here = host.scenario.name
        if file.world not in (None, here):
            problem, remedy = f"is {file.world!r:.60}, but the studio is in {here}", "open that world first"
            raise SettingError(where=UPLOADED, setting="world", problem=problem, remedy=remedy)
        return describe_robot(file, path=UPLOADED, scenario=host.scenario)
    if isinstance(world, DigitalTwin):
        robot = world.fleet.robots[0]
        return describe_robot(robot.file, path=robot.path)
    return describe_body(world)


def zip_export(
    library: Library, order: ExportOrder, body: BodyInterface | RobotInterface
) -> tuple[bytes, str]:
    """Export an automaton, and return a zip with one folder and a sentence about it."""
    stem = _find_stem(order)
    buffer = BytesIO()
    with TemporaryDirectory() as place:
        folder = Path(place) / stem
        result = export_automaton(
            library,
            order.name,
            folder,
            to=order.to,
            binding=order.binding,
            body=body,
            single_precision=order.single_precision,
        )
        with ZipFile(buffer, "w", ZIP_DEFLATED) as archive:
            for file in result.files:
                archive.write(folder / file, f"{stem}/{file}")
    return buffer.getvalue(), _describe_result(order, result)


def _describe_result(order: ExportOrder, result: ExportResult) -> str:
    missing = [f"{what} is missing, because {problem}" for what, _, problem in result.untranslated]
    return ". ".join((f"Exported {order.name} for {order.to}", *missing, *result.notes))


def _find_stem(order: ExportOrder) -> str:
    return f"{make_identifier(order.name)}-{make_identifier(order.to)}"
