"""Packages of ROS 2 that stand in for the real ones: headers of messages by their definitions, and files for CMake."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from understudy.addons.export.targets.ros2 import find_header
from understudy.records.messages import ARRAY, BASE, NAMED, list_message_fields, load_typestore

HERE = Path(__file__).parent
CPP = {
    "byte": "unsigned char", "char": "unsigned char", "bool": "bool", "float32": "float", "float64": "double",
    "string": "std::string",
}  # fmt: skip
STRICT = "-Werror -Wconversion"
SANITIZED = f"{STRICT} -fsanitize=address,undefined -fno-sanitize-recover=all"

AMENT = """
function(ament_package)
endfunction()
"""
PACKAGE = """
if(NOT TARGET stand_in)
  add_library(stand_in INTERFACE IMPORTED)
  set_target_properties(stand_in PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${{CMAKE_CURRENT_LIST_DIR}}/../include")
endif()
set({name}_TARGETS stand_in)
if("{name}" STREQUAL "rclcpp" AND NOT TARGET rclcpp::rclcpp)
  add_library(rclcpp::rclcpp ALIAS stand_in)
endif()
"""


def write_stand_ins(package: Path, place: Path) -> None:
    """Write what stands in for the packages that an exported package needs: headers, and files for CMake."""
    include, cmake = place / "include", place / "cmake"
    for name in ("rclcpp", "std_srvs"):
        shutil.copytree(HERE / name, include / name)
    node = next((package / "src").glob("*_node.cpp"))
    headers = set(re.findall(r'#include "(\w+/msg/\w+\.hpp)"', node.read_text()))
    types = [each for each in load_typestore().fielddefs if find_header(each) in headers]
    assert len(types) == len(headers)
    write_headers(include, ("builtin_interfaces/msg/Time", *types))
    cmake.mkdir(parents=True)
    for name in _list_needed(package):
        text = AMENT if name == "ament_cmake" else PACKAGE.format(name=name)
        (cmake / f"{name}Config.cmake").write_text(text)


def _list_needed(package: Path) -> list[str]:
    return re.findall(r"find_package\((\w+)", (package / "CMakeLists.txt").read_text())


def build_node(package: Path, place: Path, flags: str = STRICT) -> Path:
    """Build the node of an exported package with its own CMakeLists.txt; return the program."""
    node, build = next((package / "src").glob("*_node.cpp")), place / "build"
    where = [f"-D{name}_DIR={place / 'cmake'}" for name in _list_needed(package)]
    for command in (
        ["cmake", "-S", str(package), "-B", str(build), f"-DCMAKE_CXX_FLAGS={flags}", *where],
        ["cmake", "--build", str(build), "--target", node.stem],
    ):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
    return build / node.stem


def write_headers(include: Path, types: Sequence[str]) -> None:
    """Write the headers of types of messages, and of the types in them, into a folder."""
    for type in dict.fromkeys(_with_parts(types)):
        header = include / find_header(type)
        header.parent.mkdir(parents=True, exist_ok=True)
        header.write_text(write_header(type))
    shutil.copy(HERE / "stand_in_text.hpp", include)


def _with_parts(types: Sequence[str]) -> Iterator[str]:
    for type in types:
        for sort, of in list_message_fields(type).values():
            of = of if sort in (BASE, NAMED) else of[0][1]
            if isinstance(of, str):
                yield from _with_parts([of])
        yield type


def write_header(type: str) -> str:
    """Write the header of a type of messages: its members as rosidl generates them, and how they become words."""
    constants = load_typestore().fielddefs[type][0]
    fields = list_message_fields(type)
    package, _, name = type.split("/")
    includes = {find_header(each) for each in _with_parts([type]) if each != type}
    guard = re.sub(r"\W", "_", find_header(type)).upper()
    lines = [
        f"#ifndef {guard}", f"#define {guard}", '#include <cstdint>', '#include "stand_in_text.hpp"',
        *(f'#include "{each}"' for each in sorted(includes)), f"namespace {package}::msg", "{", f"struct {name}", "{",
    ]  # fmt: skip
    lines += [
        f"  static constexpr {_cpp(BASE, (sort, 0))} {each} = {value};"
        for each, sort, value in constants
        if sort != "string"
    ]
    lines += [f"  {_cpp(*of)} {each}{{}};" for each, of in fields.items()]
    for verb, stream, const in (
        ("read_from", "std::istream & stream", ""),
        ("write_to", "std::ostream & stream", " const"),
    ):
        calls = " ".join(f"stand_in::{verb.split('_')[0]}(stream, {each});" for each in fields)
        lines.append(f"  void {verb}({stream}){const} {{{calls or '(void)stream;'}}}")
    return "\n".join([*lines, "};", f"}}  // namespace {package}::msg", "#endif", ""])


def _cpp(sort: int, of: Any) -> str:
    if sort == NAMED:
        return str(of).replace("/", "::")
    if sort == BASE:
        return CPP.get(of[0], f"std::{of[0]}_t")
    inner, length = of
    return f"std::array<{_cpp(*inner)}, {length}>" if sort == ARRAY else f"std::vector<{_cpp(*inner)}>"


def write_words(type: str, message: Any) -> str:
    """Write a message as the stand-in headers read it."""
    return " ".join(_words((NAMED, type), message))


def _words(of: Any, value: Any) -> Iterator[str]:
    sort, inner = of
    if sort == NAMED:
        for name, field in list_message_fields(inner).items():
            yield from _words(field, getattr(value, name))
    elif sort == BASE:
        yield f"s{value.encode().hex()}" if inner[0] == "string" else repr(float(value))
    else:
        if sort != ARRAY:
            yield str(len(value))
        for each in value:
            yield from _words(inner[0], each)
