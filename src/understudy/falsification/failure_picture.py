"""The picture of a failing world: the robots' paths, and the place where it went wrong."""

from __future__ import annotations

from io import BytesIO

from understudy.falsification.failure_replay import FailureReplay
from understudy.viz.palette import INK, PAPER
from understudy.viz.path_png import draw_run, list_path_entries
from understudy.viz.sheet import FigureSheet

MARK = "#c0392b"


def draw_failure(replay: FailureReplay, *, title: str, tick_s: float) -> bytes:
    """Draw the run of a failing world as a PNG, with a mark at the robot's place when it went wrong."""
    from matplotlib.lines import Line2D

    frames = replay.frames
    last = frames[-1].view
    at = frames[min(len(frames) - 1, round(replay.wrong_s / tick_s))].view.robots
    label = f"{replay.label}, {replay.wrong_s:.1f} s"
    entry = Line2D([], [], marker="X", ls="", mfc=MARK, mec=PAPER, ms=10.0, label=label)
    subtitle = f"until {last.time_s:.0f} s; {replay.sentences[0][0].lower()}{replay.sentences[0][1:-1]}"
    sheet = FigureSheet(last, title, subtitle, [entry, *list_path_entries(frames)])
    draw_run(sheet.axes, frames, inch=sheet.inch)
    x, y = float(at.x[replay.robot]), float(at.y[replay.robot])
    sheet.axes.plot([x], [y], marker="o", ms=24.0, mfc="none", mec=MARK, mew=1.6, zorder=9)
    sheet.axes.plot([x], [y], marker="X", ms=11.0, mfc=MARK, mec=PAPER, mew=1.0, zorder=10)
    buffer = BytesIO()
    sheet.figure.savefig(buffer, format="png", edgecolor=INK)
    return buffer.getvalue()
