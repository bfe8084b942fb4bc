"""Commands `understudy robots layout` and `understudy team merge`: layouts for recordings, and merged recordings."""

from __future__ import annotations

import msgspec
import typer

from understudy.addons.robots.foxglove_layout import make_layout
from understudy.addons.robots.robot_file import list_robot_files, load_robot
from understudy.errors import join_names
from understudy.records.merge import MemberClock, merge_recordings
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.robots_options import RobotLayoutOptions, TeamMergeOptions


def write_layout(options: RobotLayoutOptions) -> None:
    """Print a layout for Foxglove: the path, states, stops and diagnostics of a robot or of a team."""
    layout = make_layout([load_robot(each) for each in list_robot_files(options.file)])
    written = msgspec.json.encode(layout)
    typer.echo((written if options.as_json else msgspec.json.format(written, indent=2)).decode())


def merge_team(options: TeamMergeOptions) -> None:
    """Merge the recordings of a team's agents into one file with one clock."""
    clock = merge_recordings(options.out, options.recordings, reference=options.reference)
    if options.as_json:
        print_json({"recording": str(options.out), "reference": clock.reference, "members": clock.members})
        return
    for each in clock.members:
        typer.echo(_describe_clock(each, clock.reference))
    typer.echo(f"Merged in {options.out}, by the clock of {clock.reference}.")


def _describe_clock(each: MemberClock, reference: str) -> str:
    """Describe how the clock of an agent was found to be."""
    killed = (
        "" if each.whole else " Its recording was not closed: what was recorded until then is all there is."
    )
    if each.agent == reference:
        return f"{each.agent}: the reference.{killed}"
    side = "ahead of" if each.ahead_s >= 0 else "behind"
    by = f" by way of {join_names(each.by_way_of)}" if each.by_way_of else ""
    uneven = f" The clocks run unevenly, by {each.uneven_s * 1e3:.2g} ms." if each.uneven_s else ""
    return (
        f"{each.agent}: clock {abs(each.ahead_s):.4f} s {side} that of {reference}, {each.drift_ppm:+.1f} ppm; "
        f"error at most {each.error_s * 1e3:.2g} ms ({each.messages} messages{by}).{uneven}{killed}"
    )
