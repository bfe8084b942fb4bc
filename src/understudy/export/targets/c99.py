"""Target c99: a header and a source in C, with programs that prove them on this computer and on microcontrollers."""

from __future__ import annotations

from collections.abc import Sequence

from understudy.export.conformance import ConformanceTick
from understudy.export.target_files import ExportJob, TargetFiles, fill_template, fill_templates
from understudy.export.targets.c99_code import CCode
from understudy.export.targets.c99_header import CHeader
from understudy.export.targets.c99_names import CNames, name_for_c
from understudy.export.targets.c99_source import INDENT, CSource, write_comment
from understudy.model.kinds import Categorical

MADE = (
    "conformance",
    "sanitized",
    "traced",
    "trace.csv",
    "embedded-m3.elf",
    "embedded-avr.elf",
    "embedded-avr.log",
)
"""What the Makefile makes."""

ZEPHYR = ("CMakeLists.txt", "prj.conf", "src/main.c")
"""The files of a program for Zephyr."""

MOST_EMBEDDED_BYTES = 14_000
"""The space for conformance rows in the flash of an ATmega328P, beside the program."""


def make_c99_files(job: ExportJob) -> TargetFiles:
    """Make the files of an export to C."""
    names = name_for_c(job.hierarchy)
    writer = _CFiles(job, names)
    functions = writer.source.write_functions()
    return TargetFiles(
        writer.make_files(),
        names.by_sort,
        (*MADE, *(f"{names.prefix}-{name}" for name in ("m3.o", "avr.o"))),
        by_hand={} if functions is None else {f"{names.prefix}_functions.h": functions},
    )


class _CFiles:
    def __init__(self, job: ExportJob, names: CNames) -> None:
        self.job, self.names, self.hierarchy = job, names, job.hierarchy
        self.single = job.single_precision
        self.source = CSource(job.hierarchy, names, single_precision=self.single)
        self.real = "float" if self.single else "double"

    def make_files(self) -> dict[str, bytes]:
        p = self.names.prefix
        values = self.values()
        header = "".join(f"{line}\n" for line in CHeader(self.job, self.names, self.source).write()).encode()
        source = CCode(self.job, self.names, self.source).write().encode()
        files = {f"{p}.h": header, f"{p}.c": source}
        files |= fill_templates("c99", values, "conformance.c", "embedded.c", "Makefile", "README.md")
        files |= fill_templates("c99", {}, "cortex-m3/start.c", "cortex-m3/m3.ld")
        files |= fill_templates("c99", values, *(f"zephyr/{name}" for name in ZEPHYR))
        files[f"arduino/{p}/{p}.ino"] = fill_template("c99/arduino.ino", values)
        files |= {f"arduino/{p}/{p}.h": header, f"arduino/{p}/{p}.c": source}
        files["embedded_rows.h"] = self.rows().encode()
        return files

    def values(self) -> dict[str, str]:
        p, hierarchy = self.names.prefix, self.hierarchy
        readings = [
            (self.names.readings[str(slot)], isinstance(slot.kind, Categorical), str(slot), slot.unit)
            for slot in hierarchy.readings
        ]
        channels = [self.names.channels[channel.name] for channel in hierarchy.channels]
        samples = [
            f"// readings.{each} = ...;  ({'index of a label' if is_label else write_comment(unit) or 'a number'})"
            for each, is_label, _, unit in readings
        ]
        used = [f"(void)commands.{channel};" for channel in channels]
        notes = [
            f"\nWrite {each.name} yourself, in `{p}_functions.h`, which later exports keep: {each.problem}."
            for each in hierarchy.functions_to_write
        ]
        if self.single:
            notes.append("\nNumbers are single precision, times whole milliseconds.")
        return {
            "name": p,
            "NAME": p.upper(),
            "title": hierarchy.name,
            "real": self.real,
            "parse": "strtof" if self.single else "strtod",
            "parse_time": "(uint32_t)strtoul(time, NULL, 10)" if self.single else "strtod(time, NULL)",
            "read": "\n".join(
                f"{INDENT * 2}READ_{'LABEL' if is_label else 'REAL'}({each});"
                for each, is_label, _, _ in readings
            ),
            "check": "\n".join(f"{INDENT * 2}CHECK_REAL({channel});" for channel in channels),
            "check_row": "\n".join(
                f"{INDENT * 2}right = right && commands.{channel} == row.commands.{channel};"
                for channel in channels
            ),
            "clock": "milliseconds (it may overflow)" if self.single else "seconds",
            "tick_s": f"{hierarchy.tick_s:g}",
            "arduino_now": "millis()" if self.single else "millis() / 1000.0",
            "arduino_readings": "\n".join(f"{INDENT}{line}" for line in samples),
            "arduino_commands": "\n".join(f"{INDENT}{line}" for line in used),
            "zephyr_now": "k_uptime_get_32()" if self.single else "(double)k_uptime_get() / 1000.0",
            "zephyr_readings": "\n".join(f"{INDENT * 2}/* {line[3:]} */" for line in samples),
            "zephyr_commands": "\n".join(f"{INDENT * 2}{line}" for line in used),
            "notes": "".join(f"{note}\n" for note in notes),
        }

    # Rows for computers without files

    def rows(self) -> str:
        hierarchy = self.hierarchy
        size = 4 if self.single else 8
        each = size * (1 + len(hierarchy.readings) + len(hierarchy.channels)) + 2 * hierarchy.depth + 8
        chosen = _choose_rows(
            self.job.conformance.ticks, self.job.conformance.recorded, max(20, MOST_EMBEDDED_BYTES // each)
        )
        lines = [f"#define ROWS {len(chosen)}", "static const row_type rows[ROWS] PROGMEM = {"]
        for tick in chosen:
            readings = [
                ("-1" if value != value else str(int(value)))
                if isinstance(slot.kind, Categorical)
                else ("ABSENT" if value != value else self.source.write_real(value))
                for slot, value in zip(hierarchy.readings, tick.readings, strict=True)
            ]
            expected = tick.expected
            commands = [self.source.write_real(value) for value in expected.commands]
            flags = [str(flag + 1) for flag in expected.flags]
            time = f"{int(tick.time)}UL" if self.single else repr(float(tick.time))
            lists = (readings or ["0"], commands or ["0"], list(map(str, expected.path)), flags)
            text = ", ".join(f"{{{', '.join(each)}}}" for each in lists)
            lines.append(
                f"{INDENT}{{{time}, {text}, {len(expected.path)}, {int(tick.starts)}, {expected.basic}}},"
            )
        return "\n".join([*lines, "};"]) + "\n"


def _choose_rows(ticks: Sequence[ConformanceTick], recorded: int, most: int) -> list[ConformanceTick]:
    """Choose rows that fit into a small memory: half from lessons, half from walks, each from the start of a run."""
    lessons = list(ticks[: min(recorded, most // 2)])
    return [*lessons, *ticks[recorded : recorded + most - len(lessons)]]
