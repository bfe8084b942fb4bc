"""Command `understudy learn drivers`: merge drives of several people into one lesson, and show contradictions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.markup import escape

from understudy.addons.recordings.driver_contradictions import (
    DriverContradiction,
    find_driver_contradictions,
    settle_driver_contradictions,
)
from understudy.addons.recordings.driver_lessons import merge_driver_lessons
from understudy.addons.recordings.segmentation_report import DriveReport, make_drive_report
from understudy.errors import SettingError, UnknownName
from understudy.records.join_records import align_labels, refuse_other_robot
from understudy.storage.json_text import select_facts
from understudy.ui.cli.commands.learn import learn_lesson
from understudy.ui.cli.commands.learn_from_drive import (
    SegmentedDrive,
    make_drive_lesson,
    open_drives,
    print_drive_report,
    say_omissions,
    segment_opened_drives,
)
from understudy.ui.cli.lesson_options import DriveOptions, LearnDriversOptions
from understudy.ui.cli.options import parse_targets
from understudy.ui.cli.output import format_count, make_console

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.model.lesson import Lesson


@dataclass(frozen=True, slots=True)
class DriversReport:
    """What the drives of several drivers were found to be.

    `drivers` has a report for each driver by name, `contradictions` what they disagree on, and `quarantined` the number
    of examples of others left out because they contradict the driver who is trusted.
    """

    drivers: Mapping[str, DriveReport]
    contradictions: Sequence[DriverContradiction]
    trusted: str | None
    quarantined: int


def group_recordings(
    recordings: Sequence[Path], drivers: Sequence[str], trust: str | None, *, where: str = "learn"
) -> dict[str, list[Path]]:
    """Group recordings by driver; a single recording without a driver's name has an empty one.

    SettingError if names do not fit the recordings, or the trusted driver is none of several.
    """

    def refuse(problem: str, remedy: str) -> SettingError:
        return SettingError(where=where, setting="--driver", problem=problem, remedy=remedy)

    names = [each.strip() for each in drivers]
    if names and len(names) != len(recordings):
        times = "once" if len(names) == 1 else f"{len(names)} times"
        problem = f"is given {times} for {format_count(len(recordings), 'recording')}"
        raise refuse(problem, "give the name of each recording's driver, in the order of the recordings")
    if "" in names:
        raise refuse("is an empty name", "give the name of who drove")
    if not names:
        names = [each.stem for each in recordings] if len(recordings) > 1 else [""]
        twice = [each for each in names if names.count(each) > 1]
        if twice:
            problem = f"is missing, and two recordings are called {twice[0]!r}"
            raise refuse(
                problem, "give the name of each recording's driver; those of one driver have the same"
            )
    grouped: dict[str, list[Path]] = {}
    for name, path in zip(names, recordings, strict=True):
        grouped.setdefault(name, []).append(path)
    if trust is not None and len(grouped) == 1:
        problem, remedy = "is not used with one driver", "leave it out, or give recordings of several"
        raise SettingError(where=where, setting="--trust", problem=problem, remedy=remedy)
    if trust is not None and trust not in grouped:
        raise UnknownName(what="driver", name=trust, where="the set of recordings", known=list(grouped))
    return grouped


def learn_drivers(options: LearnDriversOptions) -> None:
    """Learn one lesson from drives of several people: it says who showed what, and where they contradict each other."""
    options.check_name()
    grouped = group_recordings(options.recordings, options.driver or (), options.trust)
    lesson, report = learn_from_drivers(grouped, options, options.trust)
    described = [_describe_contradiction(each, options.trust) for each in report.contradictions]
    names = ("drivers", "contradictions", "trusted", "quarantined")
    facts = select_facts(report, *names, contradictions=described)
    learn_lesson(lesson, options, facts, partial(print_drivers_report, report))


def learn_from_drivers(
    recordings: Mapping[str, Sequence[Path]], asked: DriveOptions, trust: str | None
) -> tuple[Lesson, DriversReport]:
    """Segment the drives of each driver apart, and return the lesson merged of all with a report."""
    made, reports = [], {}
    for name, drive in segment_drivers(recordings, asked).items():
        with say_omissions(drive.found.drive):
            own = make_drive_lesson(drive, asked, driver=name)
            reports[name] = make_drive_report(drive.found, own, targets=parse_targets(asked.targets))
        made.append(own)
    merged = merge_driver_lessons(made).lesson
    contradictions = find_driver_contradictions(merged)
    settled = merged if trust is None else settle_driver_contradictions(merged, trust)
    quarantined = sum(bool(each.quarantined) for each in settled.examples)
    quarantined -= sum(bool(each.quarantined) for each in merged.examples)
    return settled, DriversReport(reports, contradictions, trust, quarantined)


def segment_drivers(
    recordings: Mapping[str, Sequence[Path]], asked: DriveOptions
) -> dict[str, SegmentedDrive]:
    """Segment the drives of each driver apart; all must be of the same robot."""
    opened = {name: open_drives(paths, asked) for name, paths in recordings.items()}
    first = next(iter(opened.values()))
    for each in opened.values():
        refuse_other_robot(first.drive, each.drive)
    aligned = align_labels([each.drive for each in opened.values()])
    return {
        # One library for all, so that features and behaviors are the same objects in all lessons.
        name: segment_opened_drives(
            recordings[name][0], drives._replace(drive=drive, library=first.library), asked
        )
        for (name, drives), drive in zip(opened.items(), aligned, strict=True)
    }


def _describe_contradiction(each: DriverContradiction, trust: str | None) -> dict[str, Any]:
    """Describe a contradiction for `--json`; it is settled if the examples of one of the two are in quarantine."""
    names = ("sentence", "state", "drivers", "nexts", "examples")
    facts = select_facts(each, *names, sentence=str(each), examples=each.numbers)
    return {**facts, "settled": trust in each.drivers}


def print_drivers_report(report: DriversReport) -> None:
    """Print the drives of each driver, and where drivers contradict each other."""
    out = make_console()
    for name, each in report.drivers.items():
        out.print(f"\n[bold]{escape(name)}[/]")
        print_drive_report(each)
    out.print()
    _print_contradictions(report, out)


def _print_contradictions(report: DriversReport, out: Console) -> None:
    if not report.contradictions:
        out.print("The drivers do not contradict each other.")
        return
    out.print(f"[yellow]{format_count(len(report.contradictions), 'contradiction')} between drivers[/]")
    for each in report.contradictions:
        settled = " [dim]settled[/]" if report.trusted in each.drivers else ""
        out.print(f"  {escape(str(each))}{settled}", soft_wrap=True)
    if report.trusted is not None:
        left_out = format_count(report.quarantined, "example")
        out.print(f"{escape(report.trusted)} is trusted: {left_out} of others left out", soft_wrap=True)
    else:
        out.print("[dim]--trust NAME leaves out the examples that contradict one of them[/]")
